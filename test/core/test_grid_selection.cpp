// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/grid_selection.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

TEST(GridSelection, TakesRowsAndColumnsInTheOrderGiven) {
  BeamGrid grid = toBeamGrid(noddingScan(6, 5, -0.5, 0.5, 0.4, {0.1, 0.0, 0.2}));
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  BeamGrid out;
  selectBeams(grid, {4, 1}, {0, 3, 2}, out);
  ASSERT_EQ(out.rows, 2);
  ASSERT_EQ(out.cols, 3);
  EXPECT_TRUE(out.beams_exact);
  EXPECT_FALSE(out.origin_x.empty());
  EXPECT_EQ(out.point(0), grid.point(grid.index(4, 0)));
  EXPECT_EQ(out.point(out.index(1, 1)), grid.point(grid.index(1, 3)));
  EXPECT_EQ(out.direction(out.index(1, 2)), grid.direction(grid.index(1, 2)));
  EXPECT_EQ(out.origin(out.index(0, 2)), grid.origin(grid.index(4, 2)));
}

TEST(GridSelection, LeavesOutOriginsWhereThereAreNoneAndMayBeEmpty) {
  BeamGrid grid = forwardBeams(6, 5, 0.1), out;
  grid.beams_exact = false;
  selectBeams(grid, {1}, {2, 3}, out);
  EXPECT_EQ(out.size(), 2);
  EXPECT_TRUE(out.origin_x.empty());
  EXPECT_FALSE(out.beams_exact);
  selectBeams(grid, {}, {2, 3}, out);
  EXPECT_EQ(out.size(), 0);
  EXPECT_TRUE(out.range.empty());
}

}  // namespace
}  // namespace ppc
