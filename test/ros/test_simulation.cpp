// SPDX-License-Identifier: BSD-3-Clause
// launch/simulation.launch from end to end: the polygons of every sweep lie on the faces of the simulated box.
#include "patch_plane_clustering/ros/messages.h"
#include "patch_plane_clustering/sim/scene.h"
#include "ros_test_main.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace ppc {
namespace {

/// The face that a polygon lies on, all its vertices within `tolerance` of it [m]; 0 if there is none.
std::int32_t faceOf(const PlanarPolygonMsg& polygon, const sim::Scene& scene, double tolerance) {
  const Eigen::Vector3d normal(polygon.plane.coef[0], polygon.plane.coef[1], polygon.plane.coef[2]);
  for (std::int32_t id = 1; id <= scene.planeCount(); ++id) {
    const Plane face = scene.planeInBase(id);
    if (face.normal.dot(normal) < 0.999) continue;
    const bool on_face = std::all_of(polygon.outer.points.begin(), polygon.outer.points.end(), [&](const auto& p) {
      return std::abs(face.signedDistance({p.x, p.y, p.z})) < tolerance;
    });
    if (on_face) return id;
  }
  return 0;
}

TEST(Simulation, PolygonsOfEverySweepLieOnTheFacesOfTheBox) {
  ros::NodeHandle nh;
  std::map<ros::Time, PlanarPolygonArray> sweeps;
  std::map<ros::Time, SegmentationStatistics> statistics;
  const auto a = nh.subscribe<PlanarPolygonArray>("polygons", 20, [&](const auto& m) { sweeps[m->header.stamp] = *m; });
  const auto b =
      nh.subscribe<SegmentationStatistics>("statistics", 20, [&](const auto& m) { statistics[m->header.stamp] = *m; });
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(120.0);
  while (ros::ok() && ros::WallTime::now() < end && (sweeps.size() < 4 || statistics.size() < 3)) {
    ros::spinOnce();
    ros::WallDuration(0.01).sleep();
  }
  ASSERT_GE(sweeps.size(), 4U);  // two up and two down at the least
  ASSERT_GE(statistics.size(), 3U);

  const sim::Scene scene = sim::makeScene("box", 1);
  std::vector<std::map<std::int32_t, double>> area_of_face;
  for (auto sweep = std::next(sweeps.begin()); sweep != sweeps.end(); ++sweep) {  // the first may be part of one
    std::map<std::int32_t, double> areas;
    for (const PlanarPolygonMsg& polygon : sweep->second.polygons) {
      const std::int32_t face = faceOf(polygon, scene, 0.01);
      EXPECT_GT(face, 0) << "polygon " << polygon.id << " lies on no face";
      areas[face] += polygon.area;
    }
    EXPECT_GE(areas.size(), 4U);
    EXPECT_EQ(sweep->second.header.frame_id, "tilt_base");
    area_of_face.push_back(areas);
  }
  // Nodding up and nodding down see the same box.
  for (std::size_t i = 1; i < area_of_face.size(); ++i) {
    for (const auto& [face, area] : area_of_face[0]) {
      if (area > 0.5) {
        EXPECT_NEAR(area_of_face[i][face], area, 0.05 * area) << "face " << face << ", sweep " << i;
      }
    }
  }
  for (const auto& [stamp, numbers] : statistics) {
    EXPECT_EQ(numbers.width, 682U) << stamp;
    EXPECT_GT(numbers.planar_points, 9 * numbers.valid_points / 10) << stamp;
    EXPECT_EQ(numbers.images_skipped, 0U) << stamp;
  }
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_simulation"); }
