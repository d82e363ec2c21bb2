// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief How many of some things are in the line that has most of them, and in the two that have.
struct FullestLines {
  int one = 0, two = 0;
};

/// @param things pixels, say. @param lines count of rows or columns. @param line_of line_of(thing), in [0, lines).
/// @param counts working memory.
template <typename F>
FullestLines fullestLines(const std::vector<int>& things, int lines, F&& line_of, std::vector<int>& counts) {
  counts.assign(static_cast<std::size_t>(lines), 0);
  for (const int thing : things) ++counts[line_of(thing)];
  int most = 0, second = 0;
  for (const int count : counts) {
    second = std::max(second, std::min(most, count));
    most = std::max(most, count);
  }
  return {most, most + second};
}

}  // namespace ppc
