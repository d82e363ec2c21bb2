// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include "polygon_test_tools.h"
#include "run_checks.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <random>

namespace ppc {
namespace {

using namespace testing_tools;

const auto kAnywhere = [](const Eigen::Vector3d&) { return true; };

TEST(RegionStatistics, PlaneIsExactWithoutNoiseFromNearToFar) {
  for (const double distance : {0.1, 1.0, 5.0, 30.0}) {
    BeamGrid grid = toBeamGrid(noddingScan(40, 60, -15 * kDegree, 15 * kDegree, 20 * kDegree));
    const Eigen::Vector3d normal = Eigen::Vector3d(-1.0, 0.3, -0.2).normalized();
    const auto labels = scanFaces({{{normal, -distance}, kAnywhere}}, grid);
    const auto regions = describeRegions(grid, labels);
    ASSERT_EQ(regions.size(), 1U);
    EXPECT_EQ(regions[0].id, 1);
    EXPECT_EQ(regions[0].points, 2400);
    EXPECT_LT((regions[0].plane.normal - normal).norm(), 2e-6) << distance;
    EXPECT_NEAR(regions[0].plane.d, -distance, 2e-6 * distance);
    EXPECT_LT(regions[0].rms, 1e-6 * distance);
  }
}

TEST(RegionStatistics, CentroidRmsAndCountOfKnownPoints) {
  // Four points of a square at x = 2, 1 cm in front and behind in turn: the residuals, but not the plane, see it.
  const std::vector<float> x{1.99F, 2.01F, 2.01F, 1.99F}, y{-1, 1, -1, 1}, z{-1, -1, 1, 1};
  const BeamGrid grid = beamGridFromPoints(2, 2, x, y, z);
  const auto regions = describeRegions(grid, {2, 2, {3, 3, 3, 3}});
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].id, 3);
  EXPECT_EQ(regions[0].points, 4);
  EXPECT_LT((regions[0].centroid - Eigen::Vector3d(2, 0, 0)).norm(), 1e-6);
  EXPECT_LT((regions[0].plane.normal + Eigen::Vector3d::UnitX()).norm(), 1e-4);  // towards the sensor
  EXPECT_NEAR(regions[0].plane.d, -2.0, 1e-4);
  EXPECT_NEAR(regions[0].rms, 0.01, 1e-4);
}

TEST(RegionStatistics, InvalidPixelsAndTinyRegionsDoNotCount) {
  BeamGrid grid = toBeamGrid(noddingScan(10, 10, -0.1, 0.1, 0.1));
  LabelImage labels = scanFaces({{{-Eigen::Vector3d::UnitX(), -2.0}, kAnywhere}}, grid);
  labels.labels[0] = labels.labels[1] = 2;  // two points make no plane
  for (int i = 50; i < 60; ++i) grid.range[i] = std::numeric_limits<float>::quiet_NaN();
  const auto regions = describeRegions(grid, labels);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].points, 88);
  EXPECT_TRUE(describeRegions(grid, {10, 10, std::vector<std::int32_t>(100, 0)}).empty());
}

// Normalised error squared of the plane's parameters over many noisy scans: chi-square with 3 degrees of freedom, if the
// covariance is right. Band: three standard deviations of the mean.
TEST(RegionStatistics, CovarianceHoldsUnderMonteCarlo) {
  constexpr int kRuns = 400;
  for (const double slant : {0.0, 0.8}) {
    BeamGrid clean = toBeamGrid(noddingScan(20, 30, -10 * kDegree, 10 * kDegree, 15 * kDegree, {0.05, 0.0, 0.02}));
    const Plane truth{Eigen::Vector3d(-std::cos(slant), std::sin(slant), 0.1).normalized(), -2.0};
    const auto labels = scanFaces({{truth, kAnywhere}}, clean);
    const Eigen::Vector3d t1 = truth.normal.unitOrthogonal(), t2 = truth.normal.cross(t1);
    std::mt19937 random(11);
    std::normal_distribution<float> noise(0.0F, 0.01F);
    double sum = 0.0;
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    for (int run = 0; run < kRuns; ++run) {
      BeamGrid grid = clean;
      for (float& range : grid.range) range += noise(random);
      const auto regions = describeRegions(grid, labels);
      ASSERT_EQ(regions.size(), 1U);
      const PlanarRegion& region = regions[0];
      const Eigen::Vector3d dn = region.plane.normal - truth.normal;
      const Eigen::Vector3d error(t1.dot(dn), t2.dot(dn), region.plane.d - truth.d);
      Eigen::Matrix<double, 3, 4> to_error = Eigen::Matrix<double, 3, 4>::Zero();
      to_error.block<1, 3>(0, 0) = t1.transpose();
      to_error.block<1, 3>(1, 0) = t2.transpose();
      to_error(2, 3) = 1.0;
      const Eigen::Matrix3d covariance = to_error * region.covariance * to_error.transpose();
      sum += error.dot(covariance.ldlt().solve(error));
      bias += error / kRuns;
      ASSERT_LT((region.covariance - region.covariance.transpose()).norm(), 1e-12);
      EXPECT_LT(std::abs(truth.normal.dot(region.covariance.topLeftCorner<3, 3>() * truth.normal)), 1e-7);  // |n| = 1
    }
    EXPECT_NEAR(sum / kRuns, 3.0, 3.0 * std::sqrt(6.0 / kRuns)) << "slant " << slant;
    EXPECT_LT(std::abs(bias.z()), 0.001);
  }
}

TEST(RegionStatistics, RenumberingIsBySizeThenByPlace) {
  BeamGrid grid = toBeamGrid(noddingScan(2, 6, -0.1, 0.1, 0.5));
  std::fill(grid.range.begin(), grid.range.end(), 1.0F);
  grid.range[11] = std::numeric_limits<float>::quiet_NaN();
  LabelImage labels{2, 6, {7, 7, 4, 4, 4, 4, 2, 2, 9, -5, 0, 4}};
  std::vector<LabelRun> runs;
  EXPECT_EQ(renumberBySize(grid, 2, labels, &runs), 3);
  EXPECT_EQ(labels.labels, (std::vector<std::int32_t>{2, 2, 1, 1, 1, 1, 3, 3, 0, 0, 0, 0}));
  testing_tools::expectRunsOf(labels, runs);
}

}  // namespace
}  // namespace ppc
