// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/markers.h"

#include "patch_plane_clustering/ros/triangulation.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using Ring = std::vector<Eigen::Vector3d>;

Ring circle(double radius, int corners, bool clockwise, double dent = 0.0, const Eigen::Vector2d& centre = {0.0, 0.0}) {
  Ring ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = (clockwise ? -2.0 : 2.0) * M_PI * i / corners;
    const double r = i % 2 == 0 ? radius : radius - dent;  // a star
    ring.emplace_back(centre.x() + r * std::cos(angle), centre.y() + r * std::sin(angle), 0.0);
  }
  return ring;
}

double areaOf(const Ring& ring) {
  double area = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const auto &a = ring[i], &b = ring[(i + 1) % ring.size()];
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;  // negative if clockwise
}

/// Sum of the triangles' areas, each positive if it runs counter-clockwise about the normal.
double areaOfTriangles(const Ring& corners, const Eigen::Vector3d& normal) {
  double area = 0.0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const double part = 0.5 * normal.dot((corners[i + 1] - corners[i]).cross(corners[i + 2] - corners[i]));
    EXPECT_GE(part, -1e-12);
    area += part;
  }
  return area;
}

bool covers(const Ring& corners, const Eigen::Vector3d& normal, const Eigen::Vector3d& p) {
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &a = corners[i + k], &b = corners[i + (k + 1) % 3];
      inside = inside && normal.dot((b - a).cross(p - a)) >= 0.0;
    }
    if (inside) return true;
  }
  return false;
}

PlanarPolygon starWithHoles() {
  PlanarPolygon polygon;
  polygon.id = 1;
  polygon.outer = circle(2.0, 40, false, 0.7);
  polygon.holes = {circle(0.3, 12, true, 0.1), circle(0.2, 7, true, 0.0, {0.8, 0.3}),
                   circle(0.2, 9, true, 0.0, {-0.7, 0.4})};
  return polygon;
}

TEST(Triangulation, CoversTheAreaAndLeavesHolesOpen) {
  const PlanarPolygon polygon = starWithHoles();
  double expected = areaOf(polygon.outer);
  for (const auto& hole : polygon.holes) expected += areaOf(hole);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto triangles = triangulate(polygon, up);
  ASSERT_EQ(triangles.size() % 3, 0U);
  // Any triangulation of n vertices and h holes has n + 2 h - 2 triangles.
  EXPECT_EQ(triangles.size() / 3, 40U + 12U + 7U + 9U + 2U * 3U - 2U);
  EXPECT_NEAR(areaOfTriangles(triangles, up), expected, 1e-9);
  EXPECT_TRUE(covers(triangles, up, {0.0, -0.8, 0.0}));
  EXPECT_FALSE(covers(triangles, up, {0.8, 0.3, 0.0}));                                              // a hole
  EXPECT_FALSE(covers(triangles, up, {0.01, 0.0, 0.0}));                                             // another
  EXPECT_FALSE(covers(triangles, up, {1.9 * std::cos(M_PI / 20), 1.9 * std::sin(M_PI / 20), 0.0}));  // a dent of the star
}

TEST(Triangulation, WorksInAnyPlane) {
  PlanarPolygon polygon = starWithHoles();
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.8, 0.1).normalized();
  const auto place = [&](Ring& ring) {
    for (auto& p : ring) p = turn * p + Eigen::Vector3d(10.0, -20.0, 5.0);
  };
  double expected = areaOf(polygon.outer);
  for (const auto& hole : polygon.holes) expected += areaOf(hole);
  place(polygon.outer);
  for (auto& hole : polygon.holes) place(hole);
  const Eigen::Vector3d normal = turn * Eigen::Vector3d::UnitZ();
  const auto triangles = triangulate(polygon, normal);
  EXPECT_NEAR(areaOfTriangles(triangles, normal), expected, 1e-9);
  for (const auto& p : triangles) ASSERT_NEAR(normal.dot(p - polygon.outer[0]), 0.0, 1e-9);
}

TEST(Triangulation, NothingOfNothing) {
  EXPECT_TRUE(triangulate(PlanarPolygon(), Eigen::Vector3d::UnitZ()).empty());
  PlanarPolygon line;
  line.outer = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_NEAR(areaOfTriangles(triangulate(line, Eigen::Vector3d::UnitZ()), Eigen::Vector3d::UnitZ()), 0.0, 1e-12);
}

TEST(Triangulation, RingsMayTouchInAPoint) {
  PlanarPolygon polygon;
  polygon.outer = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  polygon.holes = {{{0, 2, 0}, {1, 3, 0}, {2, 2, 0}, {1, 1, 0}}, {{2, 2, 0}, {3, 3, 0}, {3, 1, 0}}};
  const auto triangles = triangulate(polygon, Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(areaOfTriangles(triangles, Eigen::Vector3d::UnitZ()), 16.0 - 2.0 - 1.0, 1e-9);
}

using visualization_msgs::Marker;

Segmentation oneRegion() {
  Segmentation segmentation;
  PlanarRegion region;
  region.id = 1;
  region.centroid = {1.0, 0.0, 0.0};
  segmentation.regions = {region};
  segmentation.polygons = {starWithHoles()};
  return segmentation;
}

TEST(Markers, OldOnesAreDeletedFirst) {
  const auto array = toMarkers(Segmentation(), {});
  ASSERT_EQ(array.markers.size(), 1U);  // an image without planes clears the view
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

TEST(Markers, FacesOutlinesAndIdsInTheFrameOfTheImage) {
  std_msgs::Header header;
  header.frame_id = "tilt_base";
  header.stamp = ros::Time(3.0);
  const auto array = toMarkers(oneRegion(), header);
  ASSERT_EQ(array.markers.size(), 4U);
  for (const Marker& marker : array.markers) {
    EXPECT_EQ(marker.header.frame_id, "tilt_base");
    EXPECT_EQ(marker.header.stamp, ros::Time(3.0));
    EXPECT_EQ(marker.pose.orientation.w, 1.0);
  }
  const Marker &faces = array.markers[1], &outlines = array.markers[2], &text = array.markers[3];
  EXPECT_EQ(faces.type, Marker::TRIANGLE_LIST);
  EXPECT_EQ(faces.points.size(), 72U * 3U);
  EXPECT_EQ(faces.colors.size(), faces.points.size());  // coloured vertices are not lit: as bright from behind
  EXPECT_EQ(outlines.type, Marker::LINE_LIST);
  EXPECT_EQ(outlines.points.size(), 2U * (40U + 12U + 7U + 9U));
  EXPECT_EQ(outlines.colors.size(), outlines.points.size());
  EXPECT_NEAR(outlines.scale.x, 0.004, 1e-9);  // of a region 1 m away
  EXPECT_EQ(text.type, Marker::TEXT_VIEW_FACING);
  EXPECT_EQ(text.text, "1");
  EXPECT_NEAR(text.pose.position.x, 1.0, 0.05);
}

TEST(Markers, RingsAreClosed) {
  const Marker outlines = toMarkers(oneRegion(), {}).markers.at(2);
  const auto& last = outlines.points.at(2 * 40 - 1);
  EXPECT_EQ(last.x, outlines.points.at(0).x);
  EXPECT_EQ(last.y, outlines.points.at(0).y);
}

}  // namespace
}  // namespace ppc
