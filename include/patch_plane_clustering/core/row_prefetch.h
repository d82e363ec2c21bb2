// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Has the processor fetch the beams of a grid ahead of a pass that takes several rows at a time.
///
/// Processors foresee what is read along a few rows at once, but not along four rows of seven arrays: block by block, a grid
/// larger than the cache is waited for most of the time. Here its arrays are fetched as they lie in memory, row by row, some
/// lines at each step of the pass.
class RowPrefetch {
 public:
  /// For a pass over rows [row_begin, row_end) of a grid, which must outlive this, in so many steps.
  /// @param rows_ahead that are fetched before the pass has come there.
  RowPrefetch(const BeamGrid& grid, int row_begin, int row_end, int rows_ahead, int steps)
      : cols_(static_cast<std::size_t>(grid.cols)), row_(row_begin), row_end_(row_end), rows_ahead_(rows_ahead) {
    for (const std::vector<float>* numbers : {&grid.range, &grid.dir_x, &grid.dir_y, &grid.dir_z}) add(*numbers);
    for (const std::vector<float>* numbers : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) add(*numbers);
    const std::size_t lines = (cols_ + kLine - 1) / kLine * arrays_ * static_cast<std::size_t>(row_end - row_begin);
    lines_per_step_ = static_cast<int>(lines / static_cast<std::size_t>(std::max(1, steps))) + 1;
  }

  /// One step of the pass, which reads no row before `row` any more.
  void step(int row) {
    if (row_ >= std::min(row_end_, row + rows_ahead_)) return;
    const float* const numbers = numbers_[array_] + static_cast<std::size_t>(row_) * cols_;
    for (int k = 0; k < lines_per_step_; ++k, at_ += kLine) {  // perhaps a little beyond the row: it comes next
      __builtin_prefetch(numbers + at_, 0, 2);                 // into the second-level cache: in the first there is no room
    }
    if (at_ < cols_) return;
    at_ = 0;
    if (++array_ < arrays_) return;
    array_ = 0;
    ++row_;
  }

 private:
  static constexpr std::size_t kLine = 16;  // numbers fetched together

  void add(const std::vector<float>& numbers) {
    if (!numbers.empty()) numbers_[arrays_++] = numbers.data();
  }

  const float* numbers_[7] = {};
  std::size_t arrays_ = 0;
  std::size_t cols_;
  int row_, row_end_;  // next to be fetched, and one past the last
  int rows_ahead_, lines_per_step_ = 0;
  std::size_t array_ = 0;  // next to be fetched of the row
  std::size_t at_ = 0;     // numbers of this that have been fetched
};

}  // namespace ppc
