// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/connected_pieces.h"

#include "run_checks.h"

#include <gtest/gtest.h>

#include <utility>

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
  const std::vector<std::int32_t> whole = splitRuns(6, 0, 1, runs);
  EXPECT_EQ(splitComponents(0, 1, labels), whole);
  testing_tools::expectRunsOf(labels, runs);
}

}  // namespace
}  // namespace ppc
