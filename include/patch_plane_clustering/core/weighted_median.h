// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Least value such that it and those below have at least half of the weight; 0 if there are none.
///
/// By halves, each part of which is left as it lies once it is known not to hold the value: expected time grows with the
/// number of values, where sorting them would take its logarithm more.
/// @param weighted values, none of them NaN, each with a positive weight; put in another order.
inline float weightedMedian(std::vector<std::pair<float, float>>& weighted) {
  if (weighted.empty()) return 0.0F;
  float total = 0.0F;
  for (const auto& entry : weighted) total += entry.second;
  const auto less = [](const auto& a, const auto& b) { return a.first < b.first; };
  auto begin = weighted.begin(), end = weighted.end();
  float below = 0.0F;
  while (end - begin > 1) {
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, less);
    float left = below;
    for (auto entry = begin; entry != middle; ++entry) left += entry->second;
    if (2.0F * left >= total) {
      end = middle;
    } else {
      below = left;
      begin = middle;
    }
  }
  return begin->first;
}

}  // namespace ppc
