// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/connected_pieces.h"

#include <algorithm>

namespace ppc {

std::vector<std::int32_t> splitComponents(int gap_rows, int gap_cols, LabelImage& labels, std::vector<LabelRun>* runs_out) {
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
  std::vector<int> row_begin(static_cast<std::size_t>(labels.rows) + 1, 0);
  for (int r = 0; r < labels.rows; ++r) {
    row_begin[r] = static_cast<int>(runs.size());
    const int first = r * labels.cols;
    for (int c = 0, end = 0; c < labels.cols; c = end) {
      end = runEnd(labels.labels.data() + first, c, labels.cols);
      const std::int32_t label = labels.labels[first + c];
      if (label == 0) continue;
      int run = -1;
      for (int k = static_cast<int>(runs.size()) - 1; k >= row_begin[r] && runs[k].end + gap_cols >= c; --k) {
        if (runs[k].label == label) {
          run = k;
          break;
        }
      }
      if (run < 0) {
        run = static_cast<int>(runs.size());
        runs.push_back({c, c, run, label});
      }
      runs[run].end = end;
      stretches.push_back({first + c, first + end, run});
    }
  }
  row_begin[labels.rows] = static_cast<int>(runs.size());
  const auto find = [&](int i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
  };
  for (int r = 1; r < labels.rows; ++r) {
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
  if (runs_out != nullptr) {
    runs_out->clear();
    runs_out->reserve(stretches.size());
  }
  std::vector<std::int32_t> renamed(runs.size(), 0);
  std::vector<std::int32_t> before(1, 0);
  for (const Stretch& stretch : stretches) {
    std::int32_t& name = renamed[find(stretch.run)];
    if (name == 0) {
      name = static_cast<std::int32_t>(before.size());
      before.push_back(runs[stretch.run].label);
    }
    std::fill(labels.labels.begin() + stretch.begin, labels.labels.begin() + stretch.end, name);
    if (runs_out == nullptr) continue;
    if (!runs_out->empty() && runs_out->back().end == stretch.begin && runs_out->back().label == name) {
      runs_out->back().end = stretch.end;  // goes on over the end of a row
    } else {
      runs_out->push_back({name, stretch.begin, stretch.end});
    }
  }
  return before;
}

}  // namespace ppc
