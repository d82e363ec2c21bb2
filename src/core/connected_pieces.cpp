// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/connected_pieces.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kNone = -1;

using Run = SplitMemory::Run;
using Stretch = SplitMemory::Stretch;
using LatestRow = SplitMemory::LatestRow;

// Whether a run goes on at a column: neither it nor any run that began since has ended too far to the left.
bool goesOn(const std::vector<Run>& runs, int run, int column, int gap_cols) {
  for (; run < static_cast<int>(runs.size()); ++run) {
    if (runs[run].end + gap_cols < column) return false;
  }
  return true;
}

void bridgeGaps(const std::vector<LabelRun>& of_labels, int cols, int reach, int gap_cols, SplitMemory& memory) {
  std::vector<LatestRow>& latest = memory.latest;
  std::vector<Run>& runs = memory.runs;
  std::vector<Stretch>& stretches = memory.stretches;
  latest.assign(static_cast<std::size_t>(highestLabel(of_labels)) + 1, {kNone, kNone, kNone, kNone});
  runs.clear();
  stretches.clear();
  runs.reserve(of_labels.size());
  stretches.reserve(of_labels.size());
  int row = 0, row_first = 0;  // pixel
  for (const LabelRun& whole : of_labels) {
    LatestRow& seen = latest[whole.label];
    for (int begin = whole.begin, end = 0; begin < whole.end; begin = end) {
      for (; begin >= row_first + cols; row_first += cols) ++row;
      end = std::min(whole.end, row_first + cols);
      const int c = begin - row_first, next = static_cast<int>(runs.size());
      if (seen.row != row) {
        seen = {row, next, kNone, seen.row != kNone && seen.row >= row - reach ? seen.first : kNone};
      }
      if (seen.last == kNone || !goesOn(runs, seen.last, c, gap_cols)) {
        if (seen.last != kNone) runs[seen.last].right = next;
        runs.push_back({whole.label, row, c, c, seen.last, kNone, seen.first_above, kNone, next});
        seen.last = next;
      }
      runs[seen.last].end = end - row_first;
      stretches.push_back({begin, end, seen.last});
    }
  }
}

// Joins runs of a label that overlap, up to `reach` rows apart.
class PieceJoiner {
 public:
  PieceJoiner(int reach, std::vector<Run>& runs) : reach_(reach), runs_(runs) {}

  // Precondition: called for all earlier runs.
  void join(int k) {
    Run& run = runs_[k];
    int at = run.left == kNone ? run.first_above : runs_[run.left].above;
    if (at == kNone) return;
    run.above = at = lastBefore(at, run.begin);
    // Once a run covers it whole, all that is farther up is joined by way of that one.
    while (at != kNone && runs_[at].row >= run.row - reach_ && !joinRow(at, k)) {
      const Run& next = runs_[at];
      at = next.begin <= run.begin ? next.above : next.first_above;
      if (at != kNone) at = lastBefore(at, run.begin);
    }
  }

  int rootOf(int k) {
    while (runs_[k].parent != k) k = runs_[k].parent = runs_[runs_[k].parent].parent;
    return k;
  }

 private:
  // The last run of a row, from `at` on, that begins no farther right than a column; `at` if none does.
  int lastBefore(int at, int column) const {
    for (int next = runs_[at].right; next != kNone && runs_[next].begin <= column; next = runs_[next].right) at = next;
    return at;
  }

  // Joins a run with those of a row that it overlaps, from `at` on. @return whether one of them covers it.
  bool joinRow(int at, int k) {
    const Run& run = runs_[k];
    bool covered = false;
    for (; at != kNone && runs_[at].begin < run.end; at = runs_[at].right) {
      if (runs_[at].end <= run.begin) continue;
      covered = covered || (runs_[at].begin <= run.begin && runs_[at].end >= run.end);
      if (runs_[at].parent == run.parent) continue;  // as most are by then
      const int a = rootOf(at), b = rootOf(k);
      runs_[std::max(a, b)].parent = std::min(a, b);
    }
    return covered;
  }

  int reach_;
  std::vector<Run>& runs_;
};

}  // namespace

std::vector<std::int32_t> splitComponents(int gap_rows, int gap_cols, LabelImage& labels) {
  std::vector<LabelRun> runs = labelRuns(labels);
  std::vector<std::int32_t> whole;
  SplitMemory memory;
  splitRuns(labels.cols, gap_rows, gap_cols, memory, runs, whole);
  paintRuns(runs, labels);
  return whole;
}

void splitRuns(int cols, int gap_rows, int gap_cols, SplitMemory& memory, std::vector<LabelRun>& of_labels,
               std::vector<std::int32_t>& whole) {
  const int reach = gap_rows + 1;
  std::vector<Run>& runs = memory.runs;
  bridgeGaps(of_labels, cols, reach, gap_cols, memory);
  PieceJoiner pieces(reach, runs);
  for (int k = 0, n = static_cast<int>(runs.size()); k < n; ++k) pieces.join(k);
  of_labels.clear();
  std::vector<std::int32_t>& names = memory.names;
  names.assign(runs.size(), 0);
  whole.assign(1, 0);
  for (const Stretch& stretch : memory.stretches) {
    std::int32_t& name = names[pieces.rootOf(stretch.run)];
    if (name == 0) {
      name = static_cast<std::int32_t>(whole.size());
      whole.push_back(runs[stretch.run].label);
    }
    appendRun({name, stretch.begin, stretch.end}, of_labels);  // it may go on over the end of a row
  }
}

}  // namespace ppc
