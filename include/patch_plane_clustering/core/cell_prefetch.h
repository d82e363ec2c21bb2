// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

namespace ppc {

/// @brief Has the processor fetch beams and labels of a cell's rows [row_begin, row_end) from a column on, while it does
/// something else: they lie far apart.
inline void prefetchCell(const BeamGrid& grid, const LabelImage& labels, int row_begin, int row_end, int col) {
  for (int row = row_begin; row < row_end; ++row) {
    const int i = grid.index(row, col);
    prefetchBeams(grid, i);
    __builtin_prefetch(labels.labels.data() + i);
  }
}

}  // namespace ppc
