// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/connected_pieces.h"

#include <algorithm>

namespace ppc {

std::vector<std::int32_t> splitComponents(int gap_rows, int gap_cols, LabelImage& labels) {
  std::vector<LabelRun> runs = labelRuns(labels);
  std::vector<std::int32_t> whole = splitRuns(labels.cols, gap_rows, gap_cols, runs);
  paintRuns(runs, labels);
  return whole;
}

std::vector<std::int32_t> splitRuns(int cols, int gap_rows, int gap_cols, std::vector<LabelRun>& of_labels) {
  // Runs of equal labels along the rows, gaps bridged; runs of nearby rows that overlap belong together.
  struct Run {
    int begin, end, parent;
    std::int32_t label;
  };
  struct Stretch {  // of pixels without a gap
    int begin, end, run;
  };
  std::vector<Run> runs;
  std::vector<Stretch> stretches;
  runs.reserve(of_labels.size());
  stretches.reserve(of_labels.size());
  std::vector<int> row_begin(1, 0);
  int row_first = 0;  // pixel
  for (const LabelRun& whole : of_labels) {
    for (int begin = whole.begin, end = 0; begin < whole.end; begin = end) {
      for (; begin >= row_first + cols; row_first += cols) row_begin.push_back(static_cast<int>(runs.size()));
      end = std::min(whole.end, row_first + cols);
      const int c = begin - row_first;
      int run = static_cast<int>(runs.size()) - 1;
      while (run >= row_begin.back() && runs[run].end + gap_cols >= c && runs[run].label != whole.label) --run;
      if (run < row_begin.back() || runs[run].end + gap_cols < c) {
        run = static_cast<int>(runs.size());
        runs.push_back({c, c, run, whole.label});
      }
      runs[run].end = end - row_first;
      stretches.push_back({begin, end, run});
    }
  }
  const int rows = static_cast<int>(row_begin.size());
  row_begin.push_back(static_cast<int>(runs.size()));
  const auto find = [&](int i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
  };
  for (int r = 1; r < rows; ++r) {
    for (int back = 1; back <= std::min(r, gap_rows + 1); ++back) {
      int above = row_begin[r - back];
      const int above_end = row_begin[r - back + 1];
      for (int k = row_begin[r]; k < row_begin[r + 1]; ++k) {
        const Run run = runs[k];
        for (int j = above; j < above_end && runs[j].begin < run.end; ++j) {
          if (runs[j].label != run.label || run.begin >= runs[j].end) continue;
          if (runs[j].parent == runs[k].parent) continue;  // as most are by then
          const int a = find(j), b = find(k);
          runs[std::max(a, b)].parent = std::min(a, b);
        }
        while (above < above_end && runs[above].end <= runs[k].begin) ++above;
      }
    }
  }
  of_labels.clear();
  std::vector<std::int32_t> renamed(runs.size(), 0);
  std::vector<std::int32_t> before(1, 0);
  for (const Stretch& stretch : stretches) {
    std::int32_t& name = renamed[find(stretch.run)];
    if (name == 0) {
      name = static_cast<std::int32_t>(before.size());
      before.push_back(runs[stretch.run].label);
    }
    appendRun({name, stretch.begin, stretch.end}, of_labels);  // it may go on over the end of a row
  }
  return before;
}

}  // namespace ppc
