// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/noise_model.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

// What the data sheet says must not matter where there is data: it is wrong by a factor of five.
const SensorModel kWrong{0.05, 0.15, 10.0, 0.0};

// Two walls, 2 to 7 m away, with a depth edge between them.
NoiseModel estimateOn(double sigma, double relative, double correlation, std::uint64_t seed) {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.2; };
  scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.0}, left}), wall({-1.0, 0.3, 0.0}, -5.0)}, grid);
  addNoise(grid, sigma, relative, correlation, seed);
  return NoiseModel::estimate(makePatchGrid(grid, 4, true), kWrong);
}

TEST(NoiseModel, FollowsTheDataSheet) {
  const NoiseModel utm(SensorModel{0.01, 0.03, 10.0, 0.0}, 1.0);
  EXPECT_DOUBLE_EQ(utm.sigma(0.1), 0.01);
  EXPECT_DOUBLE_EQ(utm.sigma(9.9), 0.01);
  EXPECT_DOUBLE_EQ(utm.sigma(10.1), 0.03);
  EXPECT_DOUBLE_EQ(utm.sigma(1000.0), 0.03);
  EXPECT_DOUBLE_EQ(utm.sigma(-1.0), 0.01);
  const NoiseModel urg(SensorModel{0.01, 0.01, 10.0, 0.01}, 2.0);
  EXPECT_DOUBLE_EQ(urg.sigma(0.5), 0.02);
  EXPECT_NEAR(urg.sigma(3.0), 0.06, 0.0005);  // within a cell of the table
}

TEST(NoiseModel, NeverFinerThanHalfAMillimetre) {
  EXPECT_DOUBLE_EQ(NoiseModel(SensorModel{0.01, 0.03, 10.0, 0.0}, 1e-6).sigma(1.0), 0.0005);
  EXPECT_DOUBLE_EQ(estimateOn(0.0, 0.0, 0.0, 1).sigma(2.0), 0.0005);
}

TEST(NoiseModel, EstimateRecoversConstantNoise) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const NoiseModel noise = estimateOn(0.01, 0.0, 0.0, seed);
    for (const double range : {2.1, 2.2, 4.8, 5.5}) EXPECT_NEAR(noise.sigma(range), 0.01, 0.001) << range;
  }
}

TEST(NoiseModel, EstimateRecoversNoiseProportionalToRange) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const NoiseModel noise = estimateOn(0.0, 0.01, 0.0, seed);
    // Noise is taken as constant over a bin of ranges, which is 25 % wide: the mean over the bin is what can be recovered.
    const double near = 0.5 * (noise.sigma(2.05) / 2.05 + noise.sigma(2.2) / 2.2);
    EXPECT_NEAR(near, 0.01, 0.001);
    EXPECT_NEAR(noise.sigma(5.0), 0.05, 0.1 * 0.05);
    EXPECT_GT(noise.sigma(5.5), 2.0 * noise.sigma(2.1));
  }
}

TEST(NoiseModel, EstimateSeesNoiseCorrelatedAlongTheLine) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const NoiseModel noise = estimateOn(0.01, 0.0, 0.7, seed);
    for (const double range : {2.1, 5.0}) EXPECT_NEAR(noise.sigma(range), 0.01, 0.0025) << range;
  }
}

TEST(NoiseModel, EstimateIsThatOfDarkWallsBeforeBrightOnes) {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.1; };
  const LabelImage truth = scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.5}, left}), wall({-1.0, 0.0, 0.0}, -5.0)}, grid);
  Normal normal(3);
  for (int i = 0; i < grid.size(); ++i)
    grid.range[i] += static_cast<float>((truth.labels[i] == 1 ? 0.02 : 0.008) * normal());
  const NoiseModel noise = NoiseModel::estimate(makePatchGrid(grid, 4, true), kWrong);
  EXPECT_NEAR(noise.sigma(2.6), 0.02, 0.002);
  EXPECT_NEAR(noise.sigma(5.2), 0.008, 0.0008);
}

TEST(NoiseModel, EstimateIsNotFooledByClutterWithoutAnyFlatSurface) {
  for (const double clutter : {7.0, 1.0}) {  // beyond the wall, and before it
    BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
    scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
    addNoise(grid, 0.005);
    std::uint32_t state = 1;
    for (int i = 0; i < grid.size(); ++i) {
      state = 1664525U * state + 1013904223U;
      if (i % grid.cols <= 120) continue;
      const int row = i / grid.cols / 10, col = i % grid.cols / 10;  // of leaves as large as this
      const double depth = 0.2 * std::pow(0.5, (row * 2 + col) % 5);
      grid.range[i] = static_cast<float>(clutter * (0.9 + depth * (state >> 8) / 16777216.0));
    }
    const NoiseModel noise = NoiseModel::estimate(makePatchGrid(grid, 4, true), kWrong);
    EXPECT_NEAR(noise.sigma(3.1), 0.005, 0.0005) << clutter;
    // The clutter scatters by up to 0.06 of its range.
    EXPECT_LT(noise.sigma(clutter), clutter > 3.0 ? 0.0052 * 1.3 * 1.25 * 1.25 * std::pow(clutter / 3.0, 2) : 0.0075)
        << clutter;
    EXPECT_GT(noise.sigma(clutter), 0.004) << clutter;
  }
}

TEST(NoiseModel, EstimateWithoutPointsIsTheDataSheet) {
  const NoiseModel noise = NoiseModel::estimate(makePatchGrid(forwardBeams(20, 20, 0.01), 4, true), kWrong);
  EXPECT_DOUBLE_EQ(noise.sigma(2.0), 0.05);
  EXPECT_DOUBLE_EQ(noise.sigma(20.0), 0.15);
}

}  // namespace
}  // namespace ppc
