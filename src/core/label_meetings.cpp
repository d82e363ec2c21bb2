// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_meetings.h"

#include "patch_plane_clustering/core/part_lists.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

// Appends where labels meet in and from cells [begin, end), cell by cell.
void findMeetings(const PatchGrid& cells, const CellShares& all, int begin, int end, std::vector<Meeting>& meetings) {
  for (int i = begin; i < end; ++i) {
    if (!isBorderCell(cells, all.only, i)) continue;
    for (int s = all.begin[i]; s < all.begin[i + 1]; ++s) {
      const std::int32_t a = all.labels[s];
      const auto meet = [&](int t, int j) {
        const std::int32_t b = all.labels[t];
        if (a != b) meetings.push_back({Meeting::keyOf(a, b), a < b ? i : j, a < b ? j : i});
      };
      for (int t = s + 1; t < all.begin[i + 1]; ++t) meet(t, i);
      cells.forEachNeighbour(i, [&](int j) {
        if (j < i) return;
        for (int t = all.begin[j]; t < all.begin[j + 1]; ++t) meet(t, j);
      });
    }
  }
}

void sortGroups(std::vector<MeetingGroup>& groups) {
  std::sort(groups.begin(), groups.end(),
            [](const MeetingGroup& a, const MeetingGroup& b) { return a.key != b.key ? a.key < b.key : a.begin < b.begin; });
}

}  // namespace

void findMeetings(const PatchGrid& cells, const CellShares& all, LabelMeetings& meetings, int threads) {
  gatherInParts(threads, static_cast<int>(all.only.size()), meetings.all, meetings.rest,
                [&](int, int begin, int end, std::vector<Meeting>& out) { findMeetings(cells, all, begin, end, out); });
}

void groupMeetings(LabelMeetings& found) {
  std::vector<Meeting>&meetings = found.all, &sorted = found.sorted;
  const int count = static_cast<int>(meetings.size());
  std::int32_t highest = 0;
  for (const Meeting& meeting : meetings) highest = std::max(highest, Meeting::pairOf(meeting.key).second);
  found.index.start(static_cast<std::size_t>(highest) + 1);
  found.found.clear();
  found.count.clear();
  for (int begin = 0, end = 0; begin < count; begin = end) {
    for (end = begin + 1; end < count && meetings[end].key == meetings[begin].key;) ++end;
    const LabelPair pair = Meeting::pairOf(meetings[begin].key);
    const auto index = static_cast<std::size_t>(found.index.find(pair.first, pair.second));
    if (index == found.count.size()) found.count.push_back(0);
    found.count[index] += end - begin;
    found.found.push_back({index, begin, end, false});
  }
  const std::vector<LabelPairIndex::Entry>& pairs = found.index.entries();
  std::vector<int>&order = found.order, &next = found.next;
  order.resize(pairs.size());
  next.resize(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  const auto keyOf = [&](int index) { return Meeting::keyOf(pairs[index].first, pairs[index].second); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return keyOf(a) < keyOf(b); });
  std::vector<MeetingGroup>& groups = found.groups;
  groups.clear();
  int place = 0;
  for (const int index : order) {
    next[index] = place;
    groups.push_back({keyOf(index), place, place + found.count[index], false});
    place += found.count[index];
  }
  sorted.resize(meetings.size());
  for (const MeetingGroup& group : found.found) {
    for (int m = group.begin; m < group.end; ++m) sorted[next[group.key]++] = meetings[m];
  }
  std::swap(meetings, sorted);
}

void renameGroups(const std::vector<std::int32_t>& now, std::vector<MeetingGroup>& groups) {
  std::size_t kept = 0;
  for (MeetingGroup group : groups) {
    const LabelPair pair = Meeting::pairOf(group.key);
    const std::int32_t a = now[pair.first], b = now[pair.second];
    if (a == b) continue;
    group.key = Meeting::keyOf(a, b);
    group.swapped = group.swapped != (a > b);
    groups[kept++] = group;
  }
  groups.resize(kept);
  sortGroups(groups);
}

}  // namespace ppc
