// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/row_runs.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// Two labels, the lower one first.
using LabelPair = std::pair<std::int32_t, std::int32_t>;

/// @brief Numbers pairs of labels in the order in which they are met first.
class LabelPairIndex {
 public:
  struct Entry {
    std::int32_t first, second;  ///< first < second
    int next;                    ///< another one with the same first label, -1 if there is none
  };

  /// Forgets all. @param labels one more than the highest label.
  void start(std::size_t labels) {
    entries_.clear();
    latest_.assign(labels, -1);
  }

  /// The number of a pair. Borders are long: pairs met last are found first.
  int find(std::int32_t a, std::int32_t b) {
    const std::int32_t first = std::min(a, b), second = std::max(a, b);
    int& latest = latest_[first];
    for (int* link = &latest; *link >= 0; link = &entries_[*link].next) {
      const int found = *link;
      if (entries_[found].second != second) continue;
      *link = entries_[found].next;
      entries_[found].next = latest;
      return latest = found;
    }
    entries_.push_back({first, second, latest});
    return latest = static_cast<int>(entries_.size()) - 1;
  }

  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
  std::vector<int> latest_;  // of each label, as the first one of a pair
};

/// @brief Finds pairs of labels that are next to each other in a row or a column, or parted by up to `gap` pixels.
/// @param labels one more than the highest label. @param index overwritten. @param pairs set to them, lower label first, in
/// ascending order.
void findTouching(const RowRuns& runs, int gap, std::size_t labels, LabelPairIndex& index, std::vector<LabelPair>& pairs);

}  // namespace ppc
