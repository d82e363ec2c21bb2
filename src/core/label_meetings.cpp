// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_meetings.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace ppc {
namespace {

// Where labels meet in and from cells [begin, end), cell by cell.
void findMeetings(const PatchGrid& cells, const CellShares& all, int begin, int end, std::vector<Meeting>& meetings) {
  meetings.clear();
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

// Sorts groups by their pairs, those of a pair in the order they had: by the higher label, then by the lower one, as each
// time the places of a label follow from how many have lower ones. @param begin,scratch overwritten.
void sortByPairs(std::vector<MeetingGroup>& groups, std::vector<int>& begin, std::vector<MeetingGroup>& scratch) {
  std::int32_t highest = 0;
  for (const MeetingGroup& group : groups) highest = std::max(highest, Meeting::pairOf(group.key).second);
  scratch.resize(groups.size());
  for (const auto label : {&LabelPair::second, &LabelPair::first}) {
    begin.assign(static_cast<std::size_t>(highest) + 2, 0);
    for (const MeetingGroup& group : groups) ++begin[Meeting::pairOf(group.key).*label + 1];
    for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
    for (const MeetingGroup& group : groups) scratch[begin[Meeting::pairOf(group.key).*label]++] = group;
    std::swap(groups, scratch);
  }
}

}  // namespace

void findMeetings(const PatchGrid& cells, const CellShares& all, LabelMeetings& meetings, int threads) {
  const int count = static_cast<int>(all.only.size()), parts = std::max(1, threads);
  std::vector<std::vector<Meeting>>& rest = meetings.rest;  // the first part's go where all will be
  if (rest.size() + 1 < static_cast<std::size_t>(parts)) rest.resize(static_cast<std::size_t>(parts - 1));
  forEachPart(threads, parts, [&](int part) {
    findMeetings(cells, all, partBegin(count, parts, part), partBegin(count, parts, part + 1),
                 part == 0 ? meetings.all : rest[part - 1]);
  });
  for (int part = 1; part < parts; ++part) {
    meetings.all.insert(meetings.all.end(), rest[part - 1].begin(), rest[part - 1].end());
  }
}

void groupMeetings(LabelMeetings& found) {
  std::vector<Meeting>&meetings = found.all, &sorted = found.sorted;
  std::vector<MeetingGroup>& groups = found.groups;
  groups.clear();  // first, those that were found one after the other: far fewer to sort
  const int count = static_cast<int>(meetings.size());
  for (int begin = 0, end = 0; begin < count; begin = end) {
    for (end = begin + 1; end < count && meetings[end].key == meetings[begin].key;) ++end;
    groups.push_back({meetings[begin].key, begin, end, false});
  }
  sortByPairs(groups, found.label_begin, found.scratch);  // they come in the order of what they begin with
  sorted.clear();
  sorted.reserve(meetings.size());
  std::size_t kept = 0;
  for (const MeetingGroup& group : groups) {
    const int begin = static_cast<int>(sorted.size());
    sorted.insert(sorted.end(), meetings.begin() + group.begin, meetings.begin() + group.end);
    const int end = static_cast<int>(sorted.size());
    if (kept > 0 && groups[kept - 1].key == group.key) {
      groups[kept - 1].end = end;
    } else {
      groups[kept++] = {group.key, begin, end, false};
    }
  }
  groups.resize(kept);
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
