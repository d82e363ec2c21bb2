// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/wide_misfit.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 120, kCols = 320, kLine = 60;
constexpr double kSpread = 0.01;

// A wall and a floor over so wide an angle that beams move on clearly bent cones; three quarters of a line's step are left
// out before `kLine`.
BeamGrid hall(double step) {
  RangeImage image = noddingScan(kRows, kCols, -0.5 * (kRows - 1) * step, 0.5 * (kRows - 1) * step, 1.1);
  for (int r = kLine; r < kRows; ++r) {
    image.tilts[r] -= 0.75 * step;
    image.line_poses[r] = Eigen::Isometry3d(Eigen::AngleAxisd(image.tilts[r], Eigen::Vector3d::UnitY()));
  }
  BeamGrid grid = toBeamGrid(image);
  scan({wall({-1.0, 0.4, 0.1}, -3.0), wall({0.0, 0.0, 1.0}, -0.7)}, grid);
  return grid;
}

TEST(MeasureWideMisfit, IsWhatALineIsOffAgainstLinesFarOff) {
  WideMisfitMemory memory;
  for (const int reach : {1, 4, 16}) {
    BeamGrid grid = hall(0.006);
    for (int c = 0; c < kCols; ++c) {
      grid.range[grid.index(kLine, c)] += 0.02F;
      grid.range[grid.index(kLine + reach, c)] -= 0.01F;
    }
    const LineMisfit misfit = measureWideMisfit(GridLines(grid, false), kLine, reach, kSpread, memory);
    EXPECT_NEAR(misfit.before + misfit.after, 1.0, 1e-6) << reach;
    EXPECT_NEAR(misfit.after, (reach - 0.75) / (2.0 * reach - 0.75), 0.002) << reach;
    EXPECT_NEAR(misfit.range.value, 0.02 + misfit.after * 0.01, 0.0015) << reach;
    EXPECT_GT(misfit.range.samples, 150) << reach;
    EXPECT_LT(misfit.range.deviation, 0.0015) << reach;
  }
}

TEST(MeasureWideMisfit, SaysHowFarPartsOfALineDisagree) {
  BeamGrid grid = hall(0.006);
  WideMisfitMemory memory;
  const double even = measureWideMisfit(GridLines(grid, false), kLine, 4, kSpread, memory).range.deviation;
  for (int c = 0; c < kCols / 2; ++c) grid.range[grid.index(kLine, c)] += 0.008F;
  EXPECT_GT(measureWideMisfit(GridLines(grid, false), kLine, 4, kSpread, memory).range.deviation, 2.0 * even);
}

TEST(MeasureWideMisfit, SaysNothingOfLinesTooFarApartNorWithoutRanges) {
  WideMisfitMemory memory;
  const BeamGrid coarse = hall(0.02);
  EXPECT_GT(measureWideMisfit(GridLines(coarse, false), kLine, 4, kSpread, memory).range.samples, 0);
  EXPECT_EQ(measureWideMisfit(GridLines(coarse, false), kLine, 40, kSpread, memory).range.samples, 0);
  BeamGrid empty = hall(0.006);
  empty.range.assign(empty.range.size(), kNoRange);
  EXPECT_EQ(measureWideMisfit(GridLines(empty, false), kLine, 4, kSpread, memory).range.samples, 0);
}

}  // namespace
}  // namespace ppc
