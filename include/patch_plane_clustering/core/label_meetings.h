// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/label_pairs.h"
#include "patch_plane_clustering/core/patch_grid.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Two labels that meet, at two cells or in one.
struct Meeting {
  std::uint64_t key;  ///< both labels in one number, quick to sort by
  int cell, other;    ///< of the lower and the higher label

  static std::uint64_t keyOf(std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32U | static_cast<std::uint64_t>(std::max(a, b));
  }
  static LabelPair pairOf(std::uint64_t key) {
    return {static_cast<std::int32_t>(key >> 32U), static_cast<std::int32_t>(key & 0xffffffffU)};
  }
};

/// @brief Meetings [begin, end) of the same two labels.
struct MeetingGroup {
  std::uint64_t key;
  int begin, end;
  bool swapped;  ///< what had the lower label has the higher one now
};

/// @brief Where labels meet, and working memory for the search of it.
struct LabelMeetings {
  std::vector<Meeting> all;
  std::vector<MeetingGroup> groups;
  std::vector<std::vector<Meeting>> rest;  ///< of each part of the cells but the first one
  std::vector<Meeting> sorted;
  std::vector<MeetingGroup> found;  ///< meetings of one pair that were found one after the other; its index for a key
  LabelPairIndex index;
  std::vector<int> order, count, next;  ///< of pairs
};

/// @brief Finds where labels meet: `all` cell by cell, without groups.
void findMeetings(const PatchGrid& cells, const CellShares& all, LabelMeetings& meetings, int threads = 1);

/// @brief Brings meetings of the same two labels together, and makes one group a pair of them, in ascending pairs.
void groupMeetings(LabelMeetings& meetings);

/// @brief Gives groups the labels' new names, and drops those that have come to be inside of one. One pair may then have
/// several, one after the other. @param now index = label.
void renameGroups(const std::vector<std::int32_t>& now, std::vector<MeetingGroup>& groups);

}  // namespace ppc
