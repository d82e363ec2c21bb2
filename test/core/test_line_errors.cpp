// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_errors.h"

#include "patch_plane_clustering/core/segmenter.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 150, kCols = 240;
constexpr double kStep = 0.005, kSigma = 0.008;

// A wall ahead and a floor, with white noise.
BeamGrid room(double sigma = kSigma) {
  BeamGrid grid = forwardBeams(kRows, kCols, kStep);
  scan({wall({-1.0, 0.2, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.7)}, grid);
  addNoise(grid, sigma);
  return grid;
}

std::vector<double> addLineErrors(double sigma, BeamGrid& grid) {
  Normal normal(5);
  std::vector<double> errors;
  for (int r = 0; r < grid.rows; ++r) {
    errors.push_back(sigma * normal());
    for (int c = 0; c < grid.cols; ++c) grid.range[grid.index(r, c)] += static_cast<float>(errors.back());
  }
  return errors;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(EstimateLineErrors, FindsWhatTheBeamsOfALineShare) {
  BeamGrid grid = room();
  const std::vector<double> truth = addLineErrors(0.02, grid);
  const std::vector<float> found = estimateLineErrors(grid);
  ASSERT_EQ(found.size(), truth.size());
  std::vector<double> left, jumps;
  for (std::size_t r = 0; r < truth.size(); ++r) {
    left.push_back(truth[r] - found[r]);
    if (r > 0) jumps.push_back(left[r] - left[r - 1]);
  }
  EXPECT_NEAR(rms(truth), 0.02, 0.003);
  EXPECT_LT(rms(left), 0.008);   // slow changes remain
  EXPECT_LT(rms(jumps), 0.003);  // steps from line to line do not
}

TEST(EstimateLineErrors, FindsNoneInNoiseHoweverStrong) {
  EXPECT_TRUE(estimateLineErrors(room()).empty());
  EXPECT_TRUE(estimateLineErrors(room(0.04)).empty());
  EXPECT_TRUE(estimateLineErrors(room(0.0)).empty());
}

TEST(EstimateLineErrors, LeavesSmallOnesAlone) {
  BeamGrid grid = room();
  addLineErrors(0.002, grid);
  EXPECT_TRUE(estimateLineErrors(grid).empty());
}

TEST(EstimateLineErrors, NeedsLinesAndValidBeams) {
  BeamGrid few = forwardBeams(8, kCols, kStep);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, few);
  addLineErrors(0.02, few);
  EXPECT_TRUE(estimateLineErrors(few).empty());
  BeamGrid none = forwardBeams(kRows, kCols, kStep);
  EXPECT_TRUE(estimateLineErrors(none).empty());
  BeamGrid sparse = room();
  addLineErrors(0.02, sparse);
  for (int i = 0; i < sparse.size(); ++i) {
    if (i % sparse.cols > 20) sparse.range[i] = kNoRange;
  }
  EXPECT_TRUE(estimateLineErrors(sparse).empty());
}

TEST(EstimateLineErrors, KeepFacesWhole) {
  BeamGrid grid = room();
  addLineErrors(0.03, grid);
  const Segmentation found = segment(grid, Config());
  ASSERT_EQ(found.regions.size(), 2U);
  EXPECT_GT(found.regions[0].points + found.regions[1].points, 0.95 * kRows * kCols);
  Config naive;
  naive.noise_aware = false;
  EXPECT_NE(segment(grid, naive).regions.size(), 2U);
}

}  // namespace
}  // namespace ppc
