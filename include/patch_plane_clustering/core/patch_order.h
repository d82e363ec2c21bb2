// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/patch_grid.h"

#include <algorithm>

namespace ppc {

/// Rows of a band, whose patches are summed and stored together.
constexpr int kBandRows = 8;

inline int bandsOf(const PatchGrid& grid) { return (grid.rows + kBandRows - 1) / kBandRows; }

/// Blocks of a strip that begin in rows [begin, end) are those from firstBlock(begin) to firstBlock(end).
inline int firstBlock(int row, int height) { return (row + height - 1) / height; }

/// @brief Calls f(strip, k) for the k-th blocks of strips that begin in bands [begin, end) of rows, in the order of their
/// patches: band by band, strip by strip in each.
template <typename F>
void forEachBlock(const PatchGrid& grid, int begin, int end, F&& f) {
  for (int band = begin; band < end; ++band) {
    const int first_row = band * kBandRows, end_row = std::min(first_row + kBandRows, grid.rows);
    for (int strip = 0; strip < grid.strips(); ++strip) {
      const int height = grid.strip_rows[strip], last = firstBlock(end_row, height);
      for (int k = firstBlock(first_row, height); k < last; ++k) f(strip, k);
    }
  }
}

}  // namespace ppc
