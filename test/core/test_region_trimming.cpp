// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_trimming.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kNoise = 0.01;  // [m]
constexpr int kSmallest = 100;

// What surfaces show in an image of 60 x 100, all of it one region.
struct Scene {
  BeamGrid grid = forwardBeams(60, 100, 0.01);
  LabelImage truth, labels;
  NoiseModel noise{SensorModel{kNoise, kNoise, 10.0, 0.0}, 1.0};
  CoplanarityTolerance tolerance;

  explicit Scene(const std::vector<Surface>& surfaces) {
    truth = scan(surfaces, grid);
    addNoise(grid, kNoise);
    labels = truth;
    for (std::int32_t& label : labels.labels) label = label > 0 ? 1 : 0;
  }

  LabelImage trimmed(int threads = 1) const {
    LabelImage result = labels;
    TrimmingMemory memory;
    trimRegions(grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest, memory, result, threads);
    LabelImage again = labels;
    trimRegions(grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest, memory, again, threads);
    EXPECT_EQ(again.labels, result.labels);  // with memory as left
    return result;
  }

  // Share of a true face that still has a label.
  double keptOf(std::int32_t face, const LabelImage& result) const {
    int kept = 0;
    for (int i = 0; i < grid.size(); ++i) kept += truth.labels[i] == face && result.labels[i] != 0 ? 1 : 0;
    return static_cast<double>(kept) / countOf(truth, face);
  }
};

// Of a plane, what lies between two distances to the left, [m].
Surface between(const Plane& plane, double right, double left) {
  return surfaceOf({plane, [=](const Eigen::Vector3d& p) { return p.y() >= right && p.y() < left; }});
}
const Plane kWall{-Eigen::Vector3d::UnitX(), -2.0};

// A board before the sensor, eight columns wide, and its side, which leads away from it and shows as two columns or so.
Scene boardWithSide() {
  const Plane side{Eigen::Vector3d(-0.3, 1.0, 0.0).normalized(),
                   Eigen::Vector3d(-0.3, 1.0, 0.0).normalized().dot(Eigen::Vector3d(2.0, -0.3, 0.0))};
  return Scene({between(kWall, -0.46, -0.3), between(side, -0.3, -0.28)});
}

TEST(TrimRegions, TakesOffWhatLiesAlongABorder) {
  const Scene scene = boardWithSide();
  ASSERT_GT(countOf(scene.truth, 1), 400);
  ASSERT_GT(countOf(scene.truth, 2), 40);
  ASSERT_LT(countOf(scene.truth, 2), 0.25 * countOf(scene.truth, 1));
  const LabelImage result = scene.trimmed();
  EXPECT_GT(scene.keptOf(1, result), 0.9);
  EXPECT_LT(scene.keptOf(2, result), 0.5);
  EXPECT_EQ(scene.trimmed(2).labels, result.labels);
}

TEST(TrimRegions, DropsWhatIsNoPlane) {
  const Scene scene({ball({2.0, 0.0, 0.0}, 0.18)});
  ASSERT_GT(countOf(scene.truth, 1), 200);
  const LabelImage result = scene.trimmed();
  EXPECT_EQ(countOf(result, 1), 0);
}

TEST(TrimRegions, LeavesPlanesAsTheyAre) {
  for (const Plane& plane : {kWall, Plane{Eigen::Vector3d(-1.0, 1.5, 0.4).normalized(), -1.2}}) {
    const Scene scene({between(plane, -0.3, 0.3)});
    ASSERT_GT(countOf(scene.truth, 1), 500);
    EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
  }
}

TEST(TrimRegions, LeavesPlanesWhoseNoiseIsLargerThanKnown) {
  Scene scene({between(kWall, -0.6, 0.6)});
  scene.tolerance.sigma_distance = 0.002;
  scene.tolerance.sigma_angle = 0.0;
  scene.noise = NoiseModel(SensorModel{0.5 * kNoise, 0.5 * kNoise, 10.0, 0.0}, 1.0);
  ASSERT_GT(countOf(scene.truth, 1), 2000);
  EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
}

TEST(TrimRegions, LeavesWhatItCannotJudge) {
  Scene correlated = boardWithSide();
  correlated.tolerance.inflation = 2.0;
  EXPECT_EQ(correlated.trimmed().labels, correlated.labels.labels);
  const Scene large({ball({2.0, 0.0, 0.0}, 0.9)});
  ASSERT_GT(countOf(large.truth, 1), 4000);
  EXPECT_EQ(large.trimmed().labels, large.labels.labels);
  Scene small = boardWithSide();
  for (int i = 0; i < small.grid.size(); ++i) {
    if (i / small.grid.cols >= 8) small.labels.labels[i] = 0;
  }
  ASSERT_LT(countOf(small.labels, 1), kSmallest);
  EXPECT_EQ(small.trimmed().labels, small.labels.labels);
}

TEST(TrimRegions, LeavesWhatASensorsOwnErrorsMayBend) {
  Scene scene({column(8.0, 0.0, 6.0)});  // 2 m away, it sags by 3 cm
  for (int i = 0; i < scene.grid.size(); ++i) {
    if (i % scene.grid.cols < 20 || i % scene.grid.cols >= 80) scene.labels.labels[i] = 0;
  }
  ASSERT_LE(countOf(scene.labels, 1), 4000);
  EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
  scene.tolerance.sigma_angle = 0.0;
  EXPECT_EQ(countOf(scene.trimmed(), 1), 0);
}

}  // namespace
}  // namespace ppc
