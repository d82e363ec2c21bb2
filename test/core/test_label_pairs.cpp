// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_pairs.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <utility>
#include <vector>

namespace ppc {
namespace {

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

LabelImage randomImage(int rows, int cols, std::mt19937& random) {
  LabelImage labels{rows, cols, {}};
  for (int i = 0; i < rows * cols; ++i) {
    const bool again = i > 0 && random() % 3 != 0;
    labels.labels.push_back(again ? labels.labels.back() : static_cast<std::int32_t>(random() % 12U));
  }
  return labels;
}

TEST(RowRuns, AreThoseOfTheImageCutAtItsRows) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const LabelImage labels = randomImage(5, 3 + trial, random);
    RowRuns runs;
    cutAtRows(labelRuns(labels), labels.rows, labels.cols, runs);
    ASSERT_EQ(runs.rows(), labels.rows);
    std::vector<std::int32_t> painted(labels.labels.size(), 0);
    for (int r = 0; r < labels.rows; ++r) {
      for (const LabelRun* run = runs.begin(r); run != runs.end(r); ++run) {
        const bool goes_on = run + 1 != runs.end(r) && run[1].begin == run->end && run[1].label == run->label;
        EXPECT_FALSE(goes_on) << r;
        for (int c = run->begin; c < run->end; ++c) painted[r * labels.cols + c] = run->label;
      }
    }
    EXPECT_EQ(painted, labels.labels);
  }
}

TEST(RowRuns, OverlapWhereBothRowsHaveALabel) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const LabelImage labels = randomImage(2, 5 + trial, random);
    RowRuns runs;
    cutAtRows(labelRuns(labels), labels.rows, labels.cols, runs);
    Pairs found(static_cast<std::size_t>(labels.cols)), expected = found;
    forEachOverlap(runs, 0, 1, [&](const LabelRun& a, const LabelRun& b, int begin, int end) {
      for (int c = begin; c < end; ++c) found[c] = {a.label, b.label};
    });
    for (int c = 0; c < labels.cols; ++c) {
      const std::int32_t a = labels.labels[c], b = labels.labels[labels.cols + c];
      if (a > 0 && b > 0) expected[c] = {a, b};
    }
    EXPECT_EQ(found, expected);
  }
}

TEST(LabelPairIndex, NumbersPairsInTheOrderOfTheirFirstMeetings) {
  std::mt19937 random(3);
  LabelPairIndex index;
  for (int trial = 0; trial < 3; ++trial) {
    index.start(10);
    Pairs expected;
    for (int k = 0; k < 500; ++k) {
      const auto a = static_cast<std::int32_t>(random() % 10U), b = static_cast<std::int32_t>((a + 1 + random() % 9U) % 10U);
      const std::pair<std::int32_t, std::int32_t> pair(std::min(a, b), std::max(a, b));
      const auto at = std::find(expected.begin(), expected.end(), pair);
      const auto number = static_cast<int>(at - expected.begin());
      if (at == expected.end()) expected.push_back(pair);
      ASSERT_EQ(index.find(a, b), number);
    }
    ASSERT_EQ(index.entries().size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_EQ(std::pair(index.entries()[k].first, index.entries()[k].second), expected[k]);
    }
  }
}

TEST(FindTouching, LooksOverGapsInRowsAndColumns) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 60; ++trial) {
    const LabelImage labels = randomImage(6, 3 + trial / 2, random);
    const int gap = trial % 4;
    std::set<std::pair<std::int32_t, std::int32_t>> expected;
    for (int r = 0; r < labels.rows; ++r) {
      for (int c = 0; c < labels.cols; ++c) {
        const auto meet = [&](int row, int col) {
          if (row >= labels.rows || col >= labels.cols) return;
          const std::int32_t a = labels.labels[r * labels.cols + c], b = labels.labels[row * labels.cols + col];
          if (a > 0 && b > 0 && a != b) expected.emplace(std::min(a, b), std::max(a, b));
        };
        for (int g = 1; g <= gap + 1; ++g) {
          meet(r + g, c);
          meet(r, c + g);
        }
      }
    }
    RowRuns runs;
    cutAtRows(labelRuns(labels), labels.rows, labels.cols, runs);
    LabelPairIndex index;
    Pairs found;
    findTouching(runs, gap, 12, index, found);
    EXPECT_EQ(found, Pairs(expected.begin(), expected.end()));
  }
}

}  // namespace
}  // namespace ppc
