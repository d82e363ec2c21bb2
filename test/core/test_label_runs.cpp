// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_runs.h"

#include "patch_plane_clustering/core/run_listing.h"
#include "run_checks.h"

#include <gtest/gtest.h>

#include <random>
#include <tuple>
#include <utility>
#include <vector>

namespace ppc {
namespace {

// Labels in stretches of random lengths, from single pixels to several rows.
LabelImage randomStretches(int rows, int cols, std::mt19937& random) {
  LabelImage labels{rows, cols, {}};
  const int size = rows * cols;
  while (static_cast<int>(labels.labels.size()) < size) {
    const auto length = 1U << (random() % 7U);
    labels.labels.insert(labels.labels.end(), 1 + random() % length, static_cast<std::int32_t>(random() % 4U));
  }
  labels.labels.resize(static_cast<std::size_t>(size));
  return labels;
}

TEST(LabelRuns, EndWhereTheLabelChanges) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const LabelImage image = randomStretches(1, 150, random);
    const std::vector<std::int32_t>& labels = image.labels;
    for (int begin = 0; begin < 150; ++begin) {
      for (const int limit : {begin + 1, begin + (150 - begin) / 2 + 1, 150}) {
        int end = begin;
        while (end < std::min(limit, 150) && labels[end] == labels[begin]) ++end;
        ASSERT_EQ(runEnd(labels.data(), begin, std::min(limit, 150)), end);
      }
    }
  }
}

TEST(LabelRuns, ListsStretchesOfLabelsAboveZero) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const LabelImage image = randomStretches(5, 37, random);
    std::vector<std::int32_t> painted(image.labels.size(), 0);
    int last = 0;
    for (const LabelRun& run : labelRuns(image)) {
      ASSERT_GT(run.label, 0);
      ASSERT_LE(last, run.begin);
      ASSERT_LT(run.begin, run.end);
      EXPECT_FALSE(last == run.begin && last > 0 && image.labels[last - 1] == run.label);
      std::fill(painted.begin() + run.begin, painted.begin() + run.end, run.label);
      last = run.end;
    }
    EXPECT_EQ(painted, image.labels);
  }
}

TEST(LabelRuns, AreTheSameHoweverManyThreadsListThem) {
  std::mt19937 random(5);
  RunListMemory memory;
  std::vector<LabelRun> runs;
  for (const int rows : {40, 1, 7, 40}) {
    for (int threads = 1; threads <= 4; ++threads) {
      LabelImage image = randomStretches(rows, 37, random);
      listRuns(image, memory, runs, threads);
      testing_tools::expectRunsOf(image, runs);
      std::fill(image.labels.begin(), image.labels.end(), 1);  // goes on over every seam
      listRuns(image, memory, runs, threads);
      testing_tools::expectRunsOf(image, runs);
    }
  }
  listRuns(LabelImage(), memory, runs, 2);
  EXPECT_TRUE(runs.empty());
}

TEST(LabelRuns, AreThoseOfNewNames) {
  std::mt19937 random(6);
  RunListMemory memory;
  std::vector<LabelRun> runs;
  const std::vector<std::int32_t> names = {0, 1, 1, 0};
  for (int threads = 1; threads <= 4; ++threads) {
    LabelImage image = randomStretches(20, 37, random), expected = image;
    for (std::int32_t& label : expected.labels) label = names[label];
    renameAndList(names, image, memory, runs, threads);
    EXPECT_EQ(image.labels, expected.labels);
    testing_tools::expectRunsOf(expected, runs);
  }
}

TEST(LabelRuns, LooseLabelsHaveTooFewPoints) {
  std::vector<int> points{7};
  std::vector<char> loose{1, 1, 1, 1, 1, 1};
  findLoose({{1, 0, 3}, {3, 4, 5}, {1, 6, 8}, {2, 8, 12}}, 5, 5, points, loose);
  EXPECT_EQ(points, (std::vector<int>{0, 5, 4, 1, 0}));
  EXPECT_EQ(loose, (std::vector<char>{1, 0, 1, 1, 1}));
}

TEST(LabelRuns, ChangesAlongRowsAndColumns) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const LabelImage image = randomStretches(6, 20 + trial, random);
    std::vector<std::tuple<int, int, int>> found, expected;
    forEachChange(image, [&](int pixel, int step, int place) { found.emplace_back(pixel, step, place); });
    for (int r = 0; r < image.rows; ++r) {
      for (const int step : {1, image.cols}) {
        for (int c = 0; c < image.cols; ++c) {
          const int place = step == 1 ? c : r, i = r * image.cols + c;
          if (place > 0 && image.labels[i] != image.labels[i - step]) expected.emplace_back(i, step, place);
        }
      }
    }
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace ppc
