// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/part_queue.h"

#include <algorithm>
#include <vector>

namespace ppc {

/// Parts of a sample of patches, which may be looked at at a time.
constexpr int kSampleParts = 8;

/// @brief Calls f(i) for those of `count` patches that are in one part [0, kSampleParts) of an even sample of them, which
/// are `fewest` at least if there are as many: a sample tells as much as all.
template <typename F>
void forEachSample(int count, int fewest, int part, F&& f) {
  const int stride = std::max(1, count / fewest), samples = (count + stride - 1) / stride;
  const int end = partBegin(samples, kSampleParts, part + 1);
  for (int k = partBegin(samples, kSampleParts, part); k < end; ++k) f(k * stride);
}

/// Puts what other parts have found behind what the first one has.
inline void append(const std::vector<double>& more, std::vector<double>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace ppc
