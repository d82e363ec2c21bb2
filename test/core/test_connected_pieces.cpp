// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/connected_pieces.h"

#include "run_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace ppc {
namespace {

LabelImage picture(int rows, int cols, std::vector<std::int32_t> labels) { return {rows, cols, std::move(labels)}; }

TEST(SplitComponents, PartsPieces) {
  LabelImage labels = picture(3, 7, {5, 5, 0, 0, 0, 5, 5,  //
                                     5, 0, 0, 0, 0, 0, 5,  //
                                     0, 2, 2, 0, 0, 0, 5});
  splitComponents(0, 0, labels);
  EXPECT_EQ(labels.labels, (std::vector<std::int32_t>{1, 1, 0, 0, 0, 2, 2,  //
                                                      1, 0, 0, 0, 0, 0, 2,  //
                                                      0, 3, 3, 0, 0, 0, 2}));
}

TEST(SplitComponents, BridgesGapsUpToTheGivenWidth) {
  const std::vector<std::int32_t> row{4, 0, 0, 4, 0, 0, 0, 4};
  LabelImage labels = picture(1, 8, row);
  splitComponents(0, 2, labels);
  EXPECT_EQ(labels.labels, (std::vector<std::int32_t>{1, 0, 0, 1, 0, 0, 0, 2}));
  labels = picture(8, 1, row);
  splitComponents(2, 0, labels);
  EXPECT_EQ(labels.labels, (std::vector<std::int32_t>{1, 0, 0, 1, 0, 0, 0, 2}));
}

TEST(SplitComponents, JoinsBranchesThatMeetBelow) {
  LabelImage labels = picture(3, 5,
                              {1, 0, 1, 0, 1,  //
                               1, 0, 1, 0, 1,  //
                               1, 1, 1, 1, 1});
  const std::vector<std::int32_t> before = labels.labels;
  splitComponents(0, 0, labels);
  EXPECT_EQ(labels.labels, before);
}

TEST(SplitComponents, TellsWhatEachPieceWasPartOf) {
  LabelImage labels = picture(1, 7, {5, 0, 0, 5, 2, 0, 5});
  EXPECT_EQ(splitComponents(0, 0, labels), (std::vector<std::int32_t>{0, 5, 5, 2, 5}));
}

TEST(SplitComponents, TellsTheRunsOfThePieces) {
  LabelImage labels{3, 6, {1, 1, 0, 2, 2, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 3, 3, 3}};  // pieces go on over the ends of rows
  std::vector<LabelRun> runs = labelRuns(labels);
  std::vector<std::int32_t> whole;
  SplitMemory memory;
  splitRuns(6, 0, 1, memory, runs, whole);
  EXPECT_EQ(splitComponents(0, 1, labels), whole);
  testing_tools::expectRunsOf(labels, runs);
}

// Plainly: runs with their gaps bridged, each joined with all others that it overlaps, again and again.
std::vector<std::int32_t> piecesPlainly(const LabelImage& image, int gap_rows, int gap_cols) {
  struct Run {
    std::int32_t label;
    int row, begin, end, piece;
  };
  std::vector<Run> runs;
  std::vector<int> run_of(image.labels.size(), -1);
  for (int r = 0; r < image.rows; ++r) {
    const std::size_t first = runs.size();
    for (int c = 0; c < image.cols; ++c) {
      const std::int32_t label = image.labels[r * image.cols + c];
      if (label == 0) continue;
      std::size_t k = runs.size();
      if (c > 0 && image.labels[r * image.cols + c - 1] == label) {
        run_of[r * image.cols + c] = run_of[r * image.cols + c - 1];
        runs[run_of[r * image.cols + c]].end = c + 1;
        continue;
      }
      while (k > first && runs[k - 1].end + gap_cols >= c && runs[k - 1].label != label) --k;
      if (k == first || runs[k - 1].end + gap_cols < c) {
        runs.push_back({label, r, c, c, static_cast<int>(runs.size())});
        k = runs.size();
      }
      runs[k - 1].end = c + 1;
      run_of[r * image.cols + c] = static_cast<int>(k) - 1;
    }
  }
  for (bool joined = true; joined;) {
    joined = false;
    for (Run& a : runs) {
      for (const Run& b : runs) {
        const bool near = std::abs(a.row - b.row) <= gap_rows + 1 && a.row != b.row && a.begin < b.end && b.begin < a.end;
        if (a.label != b.label || !near || a.piece <= b.piece) continue;
        a.piece = b.piece;
        joined = true;
      }
    }
  }
  std::vector<std::int32_t> names(runs.size(), 0), pieces;
  std::int32_t last = 0;
  for (const int run : run_of) {
    if (run >= 0 && names[runs[run].piece] == 0) names[runs[run].piece] = ++last;
    pieces.push_back(run < 0 ? 0 : names[runs[run].piece]);
  }
  return pieces;
}

TEST(SplitComponents, FindsThePiecesOfRandomImages) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 300; ++trial) {
    const int rows = 6 + trial % 5, cols = 8 + trial % 17, gap_rows = trial % 4, gap_cols = trial % 3;
    LabelImage labels{rows, cols, {}};
    const unsigned kinds = 2 + static_cast<unsigned>(trial) % 3;
    for (int i = 0; i < rows * cols; ++i) {
      const bool again = !labels.labels.empty() && random() % 3 != 0;
      labels.labels.push_back(again ? labels.labels.back() : static_cast<std::int32_t>(random() % kinds));
    }
    const std::vector<std::int32_t> expected = piecesPlainly(labels, gap_rows, gap_cols);
    splitComponents(gap_rows, gap_cols, labels);
    ASSERT_EQ(labels.labels, expected) << rows << " x " << cols << ", gaps " << gap_rows << ' ' << gap_cols;
  }
}

}  // namespace
}  // namespace ppc
