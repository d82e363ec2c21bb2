// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ppc {

/// Standard deviation of a normal distribution over the median of its absolute deviations.
constexpr double kMadToSigma = 1.4826;
/// Standard deviation of the median of many such values over that of their mean.
constexpr double kMedianLoss = 1.2533;

/// @brief Puts those values of [begin, end) first of which `first` is true. Without branches: which values go there is not
/// foreseen by any processor. @return the end of them.
template <typename T, typename F>
T* partitionNumbers(T* begin, const T* end, const F& first) {
  T* middle = begin;
  for (T* at = begin; at != end; ++at) {
    const T value = *at;
    *at = *middle;
    *middle = value;
    middle += first(value) ? 1 : 0;
  }
  return middle;
}

/// @brief The value that would stand at `rank` (from 0) if `values`, which are numbers, were sorted; puts them in another
/// order. Hoare's selection. @param rank less than their number.
template <typename T>
T valueOfRank(std::vector<T>& values, std::size_t rank) {
  constexpr std::ptrdiff_t kFew = 16;
  constexpr int kMaxRounds = 64;  // with pivots that are bad throughout, the rest is left to one that is never slow
  T *begin = values.data(), *end = begin + values.size();
  T* const at = begin + rank;
  for (int round = 0; end - begin > kFew && round < kMaxRounds; ++round) {
    const T a = *begin, b = begin[(end - begin) / 2], c = end[-1];
    const T pivot = std::max(std::min(a, b), std::min(std::max(a, b), c));
    T* const above = partitionNumbers(begin, end, [pivot](T value) { return value < pivot; });
    if (at < above) {
      end = above;
    } else if (above != begin) {
      begin = above;
    } else {  // there is none below the pivot
      begin = partitionNumbers(begin, end, [pivot](T value) { return !(pivot < value); });
      if (at < begin) return pivot;
    }
  }
  std::nth_element(begin, at, end);
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
