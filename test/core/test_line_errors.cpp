// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_errors.h"

#include "patch_plane_clustering/core/segmenter.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

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
  const LineErrors found = estimateLineErrors(grid);
  ASSERT_EQ(found.range.size(), truth.size());
  EXPECT_TRUE(found.turn.empty());
  EXPECT_FALSE(found.in_columns);
  std::vector<double> left, jumps;
  for (std::size_t r = 0; r < truth.size(); ++r) {
    left.push_back(truth[r] - found.range[r]);
    if (r > 0) jumps.push_back(left[r] - left[r - 1]);
  }
  EXPECT_NEAR(rms(truth), 0.02, 0.003);
  EXPECT_LT(rms(left), 0.008);   // slow changes remain
  EXPECT_LT(rms(jumps), 0.003);  // steps from line to line do not
}

// What is left of errors, but for their mean.
std::vector<double> leftOf(const std::vector<double>& truth, const std::vector<double>& found) {
  std::vector<double> left;
  for (std::size_t r = 0; r < truth.size(); ++r) left.push_back(truth[r] - found[r]);
  const double mean = std::accumulate(left.begin(), left.end(), 0.0) / static_cast<double>(left.size());
  for (double& v : left) v -= mean;
  return left;
}

TEST(EstimateLineErrors, TellsWhatIsLeftOfThem) {
  EXPECT_EQ(estimateLineErrors(room()).range_left, 0.0);
  double before = 0.0;
  for (const auto& [sigma, error] : {std::pair(0.008, 0.02), std::pair(0.008, 0.04), std::pair(0.03, 0.04)}) {
    double left = 0.0, told = 0.0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      BeamGrid grid = forwardBeams(kRows, kCols, kStep);
      scan({wall({-1.0, 0.2, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.7)}, grid);
      addNoise(grid, sigma, 0.0, 0.0, seed);
      const std::vector<double> truth = addLineErrors(error, grid);
      const LineErrors found = estimateLineErrors(grid);
      ASSERT_EQ(found.range.size(), truth.size());
      left += rms(leftOf(truth, found.range));
      told += found.range_left;
    }
    EXPECT_GT(told, 0.5 * left) << sigma << ' ' << error;
    EXPECT_LT(told, 2.0 * left) << sigma << ' ' << error;
    EXPECT_GT(told, before);  // more of either leaves more
    before = told;
  }
}

TEST(EstimateLineErrors, FindsSlowChangesFromLinesFartherOff) {
  BeamGrid grid = room();
  const std::vector<double> truth = addLineErrors(0.03, grid);
  const LineErrors found = estimateLineErrors(grid);
  ASSERT_EQ(found.range.size(), truth.size());
  EXPECT_LT(rms(leftOf(truth, found.range)), 0.004);  // 0.0075 from neighbours alone
}

// Of one wall askew, all slopes have one sign: a turn explains much of what is an error of range.
TEST(EstimateLineErrors, FindsThemWhereTurnsExplainMuchOfThem) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    BeamGrid grid = forwardBeams(kRows, kCols, kStep);
    scan({wall({-1.0, 0.3, 0.6}, -3.0)}, grid);
    addNoise(grid, 0.035, 0.0, 0.0, seed);
    addLineErrors(0.02, grid);
    found += estimateLineErrors(grid).range.empty() ? 0 : 1;
  }
  EXPECT_EQ(found, 20);
}

TEST(EstimateLineErrors, FindsThemWithFewBeamsOrManyGaps) {
  for (const int stride : {1, 2}) {  // gaps here and there, or every second column alone
    BeamGrid grid = room();
    const std::vector<double> truth = addLineErrors(0.02, grid);
    BeamGrid few = forwardBeams(kRows, kCols / stride, kStep * stride);
    Normal normal(9);
    for (int i = 0; i < few.size(); ++i) {
      const int from = grid.index(i / few.cols, i % few.cols * stride);
      few.range[i] = stride > 1 || normal.uniform() > 0.12 ? grid.range[from] : kNoRange;
      few.dir_x[i] = grid.dir_x[from];
      few.dir_y[i] = grid.dir_y[from];
      few.dir_z[i] = grid.dir_z[from];
    }
    const LineErrors found = estimateLineErrors(few);
    ASSERT_EQ(found.range.size(), truth.size()) << stride;
    EXPECT_LT(rms(leftOf(truth, found.range)), 0.009) << stride;
  }
}

// A beam below the ceiling crosses part of the image: where its edges are, many beams are off against the lines beside it.
TEST(EstimateLineErrors, IsNotMisledByEdgesAlongTheLines) {
  BeamGrid grid = forwardBeams(kRows, kCols, kStep);
  const auto beam = [](const Eigen::Vector3d& p) { return p.y() > 0.3 && p.x() > 2.59 && p.z() > 0.19 && p.z() < 0.4; };
  scan({wall({-1.0, 0.2, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.7), surfaceOf({{{-1.0, 0.0, 0.0}, -2.6}, beam}),
        surfaceOf({{{0.0, 0.0, -1.0}, -0.2}, beam})},
       grid);
  addNoise(grid, kSigma);
  const std::vector<double> truth = addLineErrors(0.02, grid);
  const LineErrors found = estimateLineErrors(grid);
  ASSERT_EQ(found.range.size(), truth.size());
  EXPECT_LT(rms(leftOf(truth, found.range)), 0.005);
}

void setDirection(const Eigen::Vector3f& direction, int i, BeamGrid& grid) {
  grid.dir_x[i] = direction.x();
  grid.dir_y[i] = direction.y();
  grid.dir_z[i] = direction.z();
}

// An encoder of coarse steps: what it tells, less the truth, is returned with its sign changed.
std::vector<double> addTiltSteps(double step, BeamGrid& grid) {
  std::vector<double> errors;
  for (int r = 0; r < grid.rows; ++r) {
    const double tilt = (r - 0.5 * (grid.rows - 1)) * kStep, said = step * std::round(tilt / step);
    errors.push_back(tilt - said);
    const Eigen::AngleAxisf turn(static_cast<float>(said - tilt), Eigen::Vector3f::UnitY());
    for (int c = 0; c < grid.cols; ++c) setDirection(turn * grid.direction(grid.index(r, c)), grid.index(r, c), grid);
  }
  return errors;
}

// A floor and a ceiling ahead, seen at a grazing angle, and a wall at their end.
BeamGrid hall() {
  BeamGrid grid = forwardBeams(kRows, kCols, kStep);
  scan({wall({-1.0, 0.1, 0.0}, -6.0), wall({0.0, 0.0, 1.0}, -0.7), wall({0.0, 0.0, -1.0}, -1.1)}, grid);
  addNoise(grid, kSigma);
  return grid;
}

BeamGrid transposed(const BeamGrid& grid) {
  BeamGrid out = forwardBeams(grid.cols, grid.rows, kStep);
  out.beams_exact = false;  // as of a cloud, whose lines may be rows or columns
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const int i = grid.index(r, c), o = out.index(c, r);
      out.range[o] = grid.range[i];
      setDirection(grid.direction(i), o, out);
    }
  }
  return out;
}

// Root mean square of what is left of the errors of tilt from line to line.
double jumpsLeft(const std::vector<double>& truth, const std::vector<double>& found) {
  std::vector<double> jumps;
  for (std::size_t r = 1; r < truth.size(); ++r) {
    jumps.push_back(truth[r] - found[r] - truth[r - 1] + found[r - 1]);
  }
  return rms(jumps);
}

TEST(EstimateLineErrors, FindsStepsOfTheTilt) {
  for (const double lines_a_step : {2.7, 5.0}) {
    BeamGrid grid = hall();
    const std::vector<double> truth = addTiltSteps(lines_a_step * kStep, grid);
    const LineErrors found = estimateLineErrors(grid);
    ASSERT_EQ(found.turn.size(), truth.size()) << lines_a_step;
    EXPECT_TRUE(found.range.empty());
    EXPECT_EQ(found.range_left, 0.0);
    EXPECT_FALSE(found.in_columns);
    EXPECT_GT(rms(truth), 0.003);
    EXPECT_LT(jumpsLeft(truth, found.turn), 0.15 * jumpsLeft(truth, std::vector<double>(truth.size(), 0.0))) << lines_a_step;
  }
}

TEST(EstimateLineErrors, FindsThemWhereLinesAreColumns) {
  BeamGrid grid = hall();
  const std::vector<double> truth = addTiltSteps(2.7 * kStep, grid);
  const LineErrors found = estimateLineErrors(transposed(grid));
  ASSERT_EQ(found.turn.size(), truth.size());
  EXPECT_TRUE(found.in_columns);
  EXPECT_LT(jumpsLeft(truth, found.turn), 0.15 * jumpsLeft(truth, std::vector<double>(truth.size(), 0.0)));
}

int pointsOn(const std::vector<PlanarRegion>& regions) {
  int points = 0;
  for (const PlanarRegion& region : regions) points += region.points;
  return points;
}

TEST(EstimateLineErrors, TurnsKeepFacesWhole) {
  BeamGrid grid = hall();
  addTiltSteps(5.0 * kStep, grid);
  const Segmentation found = segment(grid, Config());
  ASSERT_EQ(found.regions.size(), 3U);
  EXPECT_GT(pointsOn(found.regions), 0.95 * kRows * kCols);
  Config naive;
  naive.noise_aware = false;
  EXPECT_LT(pointsOn(segment(grid, naive).regions), 0.8 * kRows * kCols);
}

TEST(RemoveLineErrors, PutsBeamsWhereTheyPointed) {
  const BeamGrid before = hall();
  BeamGrid grid = before;
  LineErrors errors;
  errors.turn = addTiltSteps(2.7 * kStep, grid);
  errors.range.assign(kRows, 0.03);
  for (float& range : grid.range) range += 0.03F;
  BeamGrid after;
  removeLineErrors(errors, grid, after);
  double before_removal = 0.0, left = 0.0;
  for (int i = 0; i < grid.size(); ++i) {
    ASSERT_NEAR(after.range[i], before.range[i], 1e-5);
    ASSERT_NEAR(after.direction(i).norm(), 1.0, 1e-5);
    before_removal = std::max<double>(before_removal, (grid.direction(i) - before.direction(i)).norm());
    left = std::max<double>(left, (after.direction(i) - before.direction(i)).norm());
  }
  EXPECT_GT(before_removal, 0.005);
  EXPECT_LT(left, 0.1 * before_removal);
}

TEST(EstimateLineErrors, FindsNoneInNoiseHoweverStrong) {
  EXPECT_TRUE(estimateLineErrors(room()).empty());
  EXPECT_TRUE(estimateLineErrors(room(0.04)).empty());
  EXPECT_TRUE(estimateLineErrors(room(0.0)).empty());
  EXPECT_TRUE(estimateLineErrors(hall()).empty());
}

// A box from within, of which lines are lost: the others lie anywhere between those beside them, where slopes that are
// means over some lines are wrong.
TEST(EstimateLineErrors, FindsNoneWhereLinesAreLost) {
  for (const double sigma : {0.0, 0.005, 0.01}) {
    for (const double amplitude : {0.7, 0.9}) {
      for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Normal random(seed);
        RangeImage image = noddingScan(80, 121, -amplitude, amplitude, 1.5);
        for (int r = image.rows; r-- > 0;) {
          if (random.uniform() < 0.5) image.line_poses.erase(image.line_poses.begin() + r);
        }
        image.rows = static_cast<int>(image.line_poses.size());
        image.tilts.clear();
        image.ranges.resize(static_cast<std::size_t>(image.rows) * image.cols);
        BeamGrid grid = toBeamGrid(image);
        scan({wall({1.0, 0.0, 0.0}, 4.0), wall({0.0, 1.0, 0.0}, 3.0), wall({0.0, -1.0, 0.0}, 3.0),
              wall({0.0, 0.0, 1.0}, 1.5), wall({0.0, 0.0, -1.0}, 1.5)},
             grid);
        if (sigma > 0.0) addNoise(grid, sigma);
        EXPECT_TRUE(estimateLineErrors(grid).empty()) << sigma << ' ' << amplitude << ' ' << seed;
      }
    }
  }
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
