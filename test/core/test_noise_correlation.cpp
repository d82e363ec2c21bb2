// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/noise_correlation.h"

#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.005, kStep = 0.004;

// A wall seen with white noise of 5 mm and smooth errors of a given standard deviation, waves of about `length` pixels.
NoiseCorrelation measured(double smooth, double length, int rows = 160, int cols = 240) {
  BeamGrid grid = forwardBeams(rows, cols, kStep);
  scan({wall(Eigen::Vector3d(-1.0, 0.2, 0.1), -2.0)}, grid);
  Normal white(3);
  for (int i = 0; i < grid.size(); ++i) {
    const double x = 2.0 * M_PI * (i % grid.cols) / length, y = 2.0 * M_PI * (i / grid.cols) / length;
    grid.range[i] += static_cast<float>(kSigma * white() + 2.0 * smooth * std::sin(x + 0.3 * y) * std::sin(y));
  }
  PatchGrid patches = makePatchGrid(grid, 4, true);
  const NoiseModel noise = NoiseModel::estimate(patches, SensorModel());
  weighPatches(noise, patches);
  gatePatches(noise, {0.005, 0.005, 1.0}, patches);
  return measureCorrelation(patches, estimateInflation(patches));
}

TEST(MeasureCorrelation, WhiteNoiseHasNone) {
  const NoiseCorrelation found = measured(0.0, 30.0);
  EXPECT_EQ(found.variance, 1.0);
  EXPECT_EQ(found.growth, 0.0);
  EXPECT_NEAR(found.points, 20.0, 4.0);
}

TEST(MeasureCorrelation, SmoothErrorsShowInSquares) {
  const NoiseCorrelation found = measured(0.010, 40.0);
  EXPECT_GT(found.growth, 0.3);
  EXPECT_LE(found.growth, 1.0);
  EXPECT_GT(found.variance, 1.3);                                            // squares of 16 pixels see part of a wave of 40
  EXPECT_LT(found.variance, 1.0 + 0.010 * 0.010 / (kSigma * kSigma) + 0.1);  // no more than there is
  EXPECT_LT(measured(0.002, 40.0).variance, found.variance);
}

TEST(MeasureCorrelation, FewSquaresAreNoEvidence) {
  const NoiseCorrelation found = measured(0.004, 40.0, 24, 32);
  EXPECT_EQ(found.variance, 1.0);
  EXPECT_EQ(found.growth, 0.0);
  EXPECT_EQ(measureCorrelation(PatchGrid(), 1.0).points, 1.0);
}

TEST(Inflation, GrowsBeyondAPatch) {
  CoplanarityTolerance tolerance{0.005, 0.005, 3.0};
  EXPECT_EQ(tolerance.inflationOf(1e5), 3.0);
  tolerance.inflation_growth = 0.5;
  tolerance.patch_points = 25.0;
  EXPECT_EQ(tolerance.inflationOf(10.0), 3.0);
  EXPECT_NEAR(tolerance.inflationOf(2500.0), 30.0, 1e-9);
}

}  // namespace
}  // namespace ppc
