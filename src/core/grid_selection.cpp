// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/grid_selection.h"

#include <cstddef>

namespace ppc {

void selectBeams(const BeamGrid& grid, const std::vector<int>& rows, const std::vector<int>& cols, BeamGrid& out) {
  out.rows = static_cast<int>(rows.size());
  out.cols = static_cast<int>(cols.size());
  out.beams_exact = grid.beams_exact;
  for (const auto numbers : {&BeamGrid::range, &BeamGrid::dir_x, &BeamGrid::dir_y, &BeamGrid::dir_z, &BeamGrid::origin_x,
                             &BeamGrid::origin_y, &BeamGrid::origin_z}) {
    const std::vector<float>& all = grid.*numbers;
    std::vector<float>& some = out.*numbers;
    some.resize(all.empty() ? 0 : static_cast<std::size_t>(out.size()));
    if (all.empty()) continue;
    float* at = some.data();
    for (const int row : rows) {
      for (const int col : cols) *at++ = all[grid.index(row, col)];
    }
  }
}

}  // namespace ppc
