// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_reunion.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.01;  // [m]
constexpr int kSmallest = 100, kStrip = 30;

// Four strips side by side, labels 1 to 4, each a wall so far ahead.
struct Scene {
  BeamGrid grid = forwardBeams(60, 4 * kStrip, 0.005);
  LabelImage labels;
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::Zero()};
  NoiseModel noise{SensorModel{kSigma, kSigma, 100.0, 0.0}, 1.0};
  CoplanarityTolerance tolerance;

  explicit Scene(const std::vector<double>& ahead) {
    labels = {grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()))};
    for (const double distance : ahead) planes.push_back(Eigen::Vector3d(1.0 / distance, 0.0, 0.0));
    for (int i = 0; i < grid.size(); ++i) {
      const int strip = i % grid.cols / kStrip;
      labels.labels[i] = strip + 1;
      grid.range[i] = static_cast<float>(ahead[strip] / double{grid.dir_x[i]});
    }
    addNoise(grid, kSigma);
  }

  // Labels of the strips afterwards.
  std::vector<std::int32_t> reunited() {
    const std::vector<LabelRun> runs = labelRuns(labels);
    CreaseMeetings meetings;
    findCreaseMeetings(runs, labels.rows, labels.cols, planes.size(), kSmallest, meetings);
    const JudgedImage image{grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest};
    RegionReunionMemory memory;
    LabelImage again = labels;
    std::vector<Eigen::Vector3d> planes_again = planes;
    const bool any = reuniteRegions(image, meetings, runs, memory, planes, labels);
    EXPECT_EQ(any, labels.labels != again.labels);
    EXPECT_EQ(reuniteRegions(image, meetings, runs, memory, planes_again, again), any);  // with memory as left
    EXPECT_EQ(labels.labels, again.labels);
    std::vector<std::int32_t> names;
    for (int strip = 0; strip < 4; ++strip) names.push_back(labels.labels[grid.index(30, strip * kStrip + 10)]);
    return names;
  }
};

using Names = std::vector<std::int32_t>;

TEST(ReuniteRegions, JoinsWhatHasOnePlane) {
  EXPECT_EQ(Scene({3.0, 3.0, 2.0, 3.0}).reunited(), Names({1, 1, 3, 4}));  // the last one does not touch
  EXPECT_EQ(Scene({3.0, 3.0, 3.0, 3.0}).reunited(), Names({1, 1, 1, 1}));
}

TEST(ReuniteRegions, LeavesStepsAlone) {
  EXPECT_EQ(Scene({3.0, 3.008, 3.0, 3.2}).reunited(), Names({1, 2, 3, 4}));
  EXPECT_EQ(Scene({3.0, 3.0043, 3.0, 3.2}).reunited(), Names({1, 2, 3, 4}));  // within the noise of a point, not of all
}

TEST(ReuniteRegions, GivesTheJointPlane) {
  Scene scene({3.0, 3.0, 2.0, 4.0});
  scene.planes[1] = Eigen::Vector3d(1.0 / 2.9985, 0.0003, 0.0);
  scene.planes[2] = Eigen::Vector3d(1.0 / 3.0015, 0.0003, 0.0);
  const Eigen::Vector3d other = scene.planes[3];
  const int middle = scene.grid.index(30, kStrip);
  const Eigen::Vector3d beam = scene.grid.direction(middle).cast<double>();
  const auto error = [&] { return std::abs(1.0 / scene.planes[1].dot(beam) - 3.0 / beam.x()); };
  ASSERT_GT(error(), 0.001);
  ASSERT_EQ(scene.reunited(), Names({1, 1, 3, 4}));
  EXPECT_LT(error(), 0.0004);
  EXPECT_EQ(scene.planes[3], other);
}

TEST(ReuniteRegions, NeedsMoreThanACorner) {
  Scene scene({3.0, 3.0, 2.0, 4.0});
  for (int r = 4; r < 60; ++r) scene.labels.labels[scene.grid.index(r, kStrip)] = 0;
  EXPECT_EQ(scene.reunited(), Names({1, 2, 3, 4}));
}

TEST(ReuniteRegions, IsForWhiteNoise) {
  Scene scene({3.0, 3.0, 2.0, 4.0});
  scene.tolerance.inflation = 2.0;
  EXPECT_EQ(scene.reunited(), Names({1, 2, 3, 4}));
}

}  // namespace
}  // namespace ppc
