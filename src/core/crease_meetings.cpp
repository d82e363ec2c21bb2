// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_meetings.h"

#include <algorithm>
#include <tuple>

namespace ppc {
namespace {

// In scan order; counts the points of labels on the way.
void listMeetings(int rows, int cols, std::size_t labels, CreaseMeetings& out) {
  const RowRuns& runs = out.runs;
  out.points.assign(labels, 0);
  out.meetings.clear();
  out.index.start(labels);
  for (int r = 0; r < rows; ++r) {
    const int row = r * cols;
    for (const LabelRun* run = runs.begin(r); run != runs.end(r); ++run) {
      out.points[run->label] += run->end - run->begin;
      if (run == runs.begin(r) || run[-1].end != run->begin) continue;
      out.meetings.push_back({out.index.find(run[-1].label, run->label), {row + run->begin, 0}});
    }
    if (r == 0) continue;
    forEachOverlap(runs, r - 1, r, [&](const LabelRun& above, const LabelRun& below, int begin, int end) {
      if (above.label == below.label) return;
      out.meetings.push_back({out.index.find(above.label, below.label), {row + begin, end - begin}});
    });
  }
}

// Pairs of labels of which both have enough points.
void listPairs(int smallest, CreaseMeetings& out) {
  std::vector<int>& count = out.next;
  count.assign(out.index.entries().size(), 0);
  for (const CreaseMeetings::Meeting& meeting : out.meetings) ++count[meeting.pair];
  out.pairs.clear();
  int index = 0;
  for (const LabelPairIndex::Entry& entry : out.index.entries()) {
    const bool large = out.points[entry.first] >= smallest && out.points[entry.second] >= smallest;
    if (large) out.pairs.push_back({entry.first, entry.second, index, 0, count[index]});
    ++index;
  }
  std::sort(out.pairs.begin(), out.pairs.end(), [](const CreaseMeetings::Pair& a, const CreaseMeetings::Pair& b) {
    return std::tie(a.first, a.second) < std::tie(b.first, b.second);
  });
}

// Brings the meetings of each pair together.
void groupByPair(CreaseMeetings& out) {
  std::fill(out.next.begin(), out.next.end(), -1);  // pairs that take no part
  int begin = 0;
  for (CreaseMeetings::Pair& pair : out.pairs) {
    out.next[pair.index] = pair.begin = begin;
    pair.end = begin += pair.end;
  }
  out.places.resize(static_cast<std::size_t>(begin));
  for (const CreaseMeetings::Meeting& meeting : out.meetings) {
    int& next = out.next[meeting.pair];
    if (next >= 0) out.places[next++] = meeting.place;
  }
}

}  // namespace

void findCreaseMeetings(const std::vector<LabelRun>& runs, int rows, int cols, std::size_t labels, int smallest,
                        CreaseMeetings& out) {
  cutAtRows(runs, rows, cols, out.runs);
  listMeetings(rows, cols, labels, out);
  listPairs(smallest, out);
  groupByPair(out);
}

}  // namespace ppc
