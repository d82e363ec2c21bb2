// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_resolver.h"
#include "patch_plane_clustering/core/clustering.h"

#include "cell_test_tools.h"

#include <gtest/gtest.h>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

class CellsOf : public ::testing::TestWithParam<int> {};

TEST_P(CellsOf, AreResolvedAsByPlainArithmetic) {
  const int size = GetParam();
  const Walls walls(13, 31);
  PatchGrid cells = makePatchGrid(walls.grid, size, false);
  for (int& rows : cells.strip_rows) rows = 2 * size;  // windows that reach two rows up and down
  ResolverMemory memory;
  CellResolver resolver(walls.grid, cells, walls.planes, kNoise, kTolerance, memory);
  int left_out = 0, changed = 0;
  for (const bool keep : {false, true}) {
    LabelImage labels = walls.truth;
    for (int i = 0; i < walls.grid.size(); ++i) {
      if (i % 5 != 0) labels.labels[i] = i % 3 == 0 ? 0 : 2;
    }
    const LabelImage before = labels;
    for (const Patch& cell : cells.patches) {
      // The middle of a cell has a measurement here wherever the pixel that is looked for first has one.
      const int width = cell.col_end - cell.col_begin, half = width * (cell.row_end - cell.row_begin) / 2;
      const int middle = walls.grid.index(cell.row_begin + half / width, cell.col_begin + half % width);
      if (!walls.grid.valid(middle)) continue;
      const PlainResolver plain(walls, cells.center, middle);
      resolver.resolve(cell, {1, 2, 3}, 2, keep, labels);
      for (int r = cell.row_begin; r < cell.row_end; ++r) {
        for (int c = cell.col_begin; c < cell.col_end; ++c) {
          const int i = walls.grid.index(r, c);
          const std::int32_t was = before.labels[i];
          const std::int32_t expected = was == 1 ? 1 : plain.winner(r, c, 2, keep ? was : 0);
          EXPECT_EQ(labels.labels[i], expected) << r << ", " << c << ", cells of " << size;
          left_out += expected == 0 ? 1 : 0;
          changed += expected != was ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(left_out, 20);
  EXPECT_GT(changed, 50);
}

INSTANTIATE_TEST_SUITE_P(Widths, CellsOf, ::testing::Values(2, 3, 4, 5, 7, 8));

}  // namespace
}  // namespace ppc
