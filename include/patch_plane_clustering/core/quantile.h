// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ppc {

/// Standard deviation of a normal distribution over the median of its absolute deviations.
constexpr double kMadToSigma = 1.4826;

/// @brief The value that would stand at `rank` (from 0) if `values` were sorted; puts them in another order.
/// @param rank less than their number.
template <typename T>
T valueOfRank(std::vector<T>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// @brief The smallest (share 0), the largest (share 1), or the value in between below which that share of the others is.
/// @param values at least one; put in another order.
template <typename T>
T quantile(std::vector<T>& values, double share) {
  return valueOfRank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

/// @brief The middle one, the upper of two. @param values at least one; put in another order.
template <typename T>
T median(std::vector<T>& values) {
  return valueOfRank(values, values.size() / 2);
}

}  // namespace ppc
