// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_fit.h"

#include "patch_plane_clustering/core/across_fit.h"

#include "analytic_scenes.h"
#include "naive_beam_fit.h"

#include <gtest/gtest.h>
#include <utility>

namespace ppc {
namespace {

using namespace testing_tools;

const auto kAnywhere = [](const Eigen::Vector3d&) { return true; };

BeamGrid noisyWall(const Plane& plane, const Eigen::Vector3d& lever_arm) {
  BeamGrid grid = toBeamGrid(noddingScan(13, 37, -15 * kDegree, 15 * kDegree, 20 * kDegree, lever_arm));
  scanFaces({{plane, kAnywhere}}, grid);
  addNoise(grid, 0.02);
  grid.range[20] = grid.range[100] = kNoRange;
  return grid;
}

// Of some blocks, the last of which ends where the grid does.
TEST(BeamFit, SumsAreThoseOfEachPoint) {
  const Plane plane{Eigen::Vector3d(-1.0, 0.4, -0.2).normalized(), -2.0};
  for (const auto& [lever, softness] : {std::pair{0.0, 0.0}, {0.1, 0.0}, {0.1, 0.3}}) {
    const BeamGrid grid = noisyWall(plane, {lever, 0.0, 0.5 * lever});
    const std::vector<PixelStretch> blocks{{3, 60}, {90, 91}, {91, 200}, {grid.size() - 7, grid.size()}};
    const double limit = 0.03;
    const BeamFrame frame({plane.normal, plane.d + 0.005}, {1.9, 0.1, 0.2});
    const BeamSums sums =
        sumBeams(grid, blocks.data(), blocks.data() + blocks.size(), frame, BeamWeights::kTrimmed, {limit, softness});
    BeamSums naive;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const PixelStretch& block : blocks) {
      for (int i = block.begin; i < block.end; ++i) {
        if (!grid.valid(i)) continue;
        const NaiveTerm term = naiveTerm(grid, i, frame.plane(), softness);
        const double w = term.w, h = term.h;
        const Eigen::Vector3d q = term.foot - frame.centre();
        mean += grid.point(i).cast<double>();
        ++naive.valid;
        naive.hh += h * h;
        if (w * h * h > limit * limit) continue;
        ++naive.kept;
        naive.w += w;
        naive.wab += w * q[frame.a()] * q[frame.b()];
        naive.waa += w * q[frame.a()] * q[frame.a()];
        naive.wha += w * h * q[frame.a()];
        naive.whh += w * h * h;
      }
    }
    EXPECT_EQ(sums.valid, naive.valid);
    EXPECT_EQ(sums.used, naive.valid);
    EXPECT_EQ(sums.kept, naive.kept);
    EXPECT_LT(sums.kept, sums.valid);
    EXPECT_NEAR(sums.w, naive.w, 1e-5 * naive.w);
    EXPECT_NEAR(sums.waa, naive.waa, 1e-5 * naive.waa);
    EXPECT_NEAR(sums.wab, naive.wab, 1e-5 * naive.waa);
    EXPECT_NEAR(sums.wha, naive.wha, 1e-5 * std::sqrt(naive.waa * naive.whh));
    EXPECT_NEAR(sums.whh, naive.whh, 1e-4 * naive.whh);
    EXPECT_NEAR(sums.hh, naive.hh, 1e-4 * naive.hh);
    EXPECT_LT((frame.meanOf(sums) - mean / naive.valid).norm(), 2e-6);
  }
}

TEST(BeamFit, BeamsAlongThePlaneAreNotUsed) {
  BeamGrid grid = toBeamGrid(noddingScan(2, 5, -0.1, 0.1, 0.1));
  std::fill(grid.range.begin(), grid.range.end(), 2.0F);
  const PixelStretch all{0, grid.size()};
  const BeamFrame along({Eigen::Vector3d::UnitY(), 0.0}, {2.0, 0.0, 0.0});
  const BeamSums sums = sumBeams(grid, &all, &all + 1, along, BeamWeights::kTrimmed, {1e9});
  EXPECT_EQ(sums.valid, 10);
  EXPECT_EQ(sums.used, 4);  // those to the right, which meet it from the front
  EXPECT_FALSE(stepOf(BeamSums()));
}

// From a plane that faces the sensor to one that is seen at 75 deg, in one step: inverse ranges are linear in n / d.
TEST(BeamFit, InverseRangesLeadToThePlaneInOneStep) {
  const Plane plane{Eigen::Vector3d(-0.26, 0.97, 0.05).normalized(), -0.5};
  BeamGrid grid = toBeamGrid(noddingScan(20, 30, -10 * kDegree, 10 * kDegree, 10 * kDegree));
  scanFaces({{plane, kAnywhere}}, grid);
  const std::vector<PixelStretch> blocks{{0, 200}, {200, 400}, {400, 600}};
  const BeamFrame facing({-Eigen::Vector3d::UnitX(), -2.0}, {2.0, 0.0, 0.0});
  const BeamSums sums = sumBeams(grid, blocks.data(), blocks.data() + blocks.size(), facing, BeamWeights::kInverse);
  const std::optional<BeamStep> step = stepOf(sums);
  ASSERT_TRUE(step);
  const Plane found = movedBy(*step, facing, Eigen::Vector3d::Zero());
  EXPECT_LT((found.normal - plane.normal).norm(), 1e-4);
  EXPECT_NEAR(found.d, plane.d, 1e-4);
}

TEST(BeamFit, ReachesTheConvergedPlane) {
  const Plane plane{Eigen::Vector3d(-1.0, 0.8, 0.1).normalized(), -2.0};
  const BeamGrid grid = noisyWall(plane, {0.05, 0.0, 0.02});
  std::vector<PixelStretch> blocks;
  std::vector<int> pixels;
  for (int r = 0; r < grid.rows; ++r) blocks.push_back({r * grid.cols, (r + 1) * grid.cols});
  for (int i = 0; i < grid.size(); ++i) {
    if (grid.valid(i)) pixels.push_back(i);
  }
  for (const double softness : {0.0, 0.3}) {
    Plane at = plane;
    for (int k = 0; k < 6; ++k) {
      const BeamFrame frame(at, {2.0, 0.0, 0.0});
      const BeamSums sums =
          sumBeams(grid, blocks.data(), blocks.data() + blocks.size(), frame, BeamWeights::kTrimmed, {1e9, softness});
      at = movedBy(*stepOf(sums), frame, Eigen::Vector3d::Zero());
    }
    const Plane naive = naiveBeamFit(grid, pixels, plane, 1e9, softness);
    EXPECT_LT((at.normal - naive.normal).norm(), 2e-6) << softness;
    EXPECT_NEAR(at.d, naive.d, 2e-6) << softness;
  }
}

// With errors across the beams alone it is the plane of total least squares.
TEST(BeamFit, IsTotalLeastSquaresWithoutErrorsAlongBeams) {
  const Plane plane{Eigen::Vector3d(-1.0, 0.8, 0.1).normalized(), -2.0};
  const BeamGrid grid = noisyWall(plane, {0.05, 0.0, 0.02});
  const PixelStretch all{0, grid.size()};
  PointSums points;
  const Eigen::Vector3d about(2.0, 0.0, 0.0);
  addPoints(grid, 0, grid.size(), about, points);
  const Plane across = fitAcross(1, about, points).plane;
  Plane at = plane;
  for (int k = 0; k < 10; ++k) {
    const BeamFrame frame(at, about);
    at = movedBy(*stepOf(sumBeams(grid, &all, &all + 1, frame, BeamWeights::kTrimmed, {1e9, 1e6})), frame,
                 Eigen::Vector3d::Zero());
  }
  EXPECT_LT((at.normal - across.normal).norm(), 1e-5);
  EXPECT_NEAR(at.d, across.d, 1e-5);
}

}  // namespace
}  // namespace ppc
