// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Runs of labels that end where rows do: for what looks from row to row without looking at pixels.
struct RowRuns {
  std::vector<LabelRun> runs;  ///< row by row, from left to right; their begin and end are columns
  std::vector<int> row_begin;  ///< of each row's part of `runs`, and one past the last

  int rows() const { return static_cast<int>(row_begin.size()) - 1; }
  const LabelRun* begin(int row) const { return runs.data() + row_begin[static_cast<std::size_t>(row)]; }
  const LabelRun* end(int row) const { return begin(row + 1); }
};

/// @brief Cuts runs that may go on over the ends of rows (listRuns()). @param rows,cols of the image. @param out
/// overwritten.
inline void cutAtRows(const std::vector<LabelRun>& of_image, int rows, int cols, RowRuns& out) {
  out.runs.clear();
  out.row_begin.assign(1, 0);
  int row_first = 0;  // pixel
  for (const LabelRun& run : of_image) {
    for (int begin = run.begin, end = 0; begin < run.end; begin = end) {
      for (; begin >= row_first + cols; row_first += cols) out.row_begin.push_back(static_cast<int>(out.runs.size()));
      end = std::min(run.end, row_first + cols);
      out.runs.push_back({run.label, begin - row_first, end - row_first});
    }
  }
  out.row_begin.resize(static_cast<std::size_t>(rows) + 1, static_cast<int>(out.runs.size()));
}

/// @brief Calls f(a, b, begin, end) for runs a of one row and b of another one that have columns [begin, end) in common,
/// from left to right.
template <typename F>
void forEachOverlap(const RowRuns& runs, int row, int other, F&& f) {
  const LabelRun *a = runs.begin(row), *b = runs.begin(other);
  const LabelRun *const a_end = runs.end(row), *const b_end = runs.end(other);
  while (a != a_end && b != b_end) {
    const int begin = std::max(a->begin, b->begin), end = std::min(a->end, b->end);
    if (begin < end) f(*a, *b, begin, end);
    const bool of_a = a->end == end, of_b = b->end == end;  // which of them ends here, without branches
    a += of_a ? 1 : 0;
    b += of_b ? 1 : 0;
  }
}

}  // namespace ppc
