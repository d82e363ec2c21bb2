// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/segcomp.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ppc {
namespace {

// Runs of (label, number of pixels), one row.
LabelImage row(const std::vector<std::pair<int, int>>& runs) {
  LabelImage image{1, 0, {}};
  for (const auto& [label, n] : runs) image.labels.insert(image.labels.end(), static_cast<std::size_t>(n), label);
  image.cols = static_cast<int>(image.labels.size());
  return image;
}

TEST(Segcomp, SameRegionsUnderOtherNamesAreCorrect) {
  const auto overlap = overlapOf(row({{1, 500}, {0, 100}, {2, 400}}), row({{7, 500}, {0, 100}, {3, 400}}));
  const SegcompScore score = segcomp(overlap, 0.95);
  EXPECT_EQ(score.correct, 2);
  EXPECT_EQ(score.over_segmented + score.under_segmented + score.missed + score.noise, 0);
  EXPECT_DOUBLE_EQ(f1(overlap, score), 1.0);
  EXPECT_DOUBLE_EQ(overlapScore(overlap).mean_iou, 1.0);
}

TEST(Segcomp, ToleranceIsAShareOfBothRegions) {
  // 80 of 100 true pixels found, and 80 of the 100 found pixels are true.
  const auto overlap = overlapOf(row({{1, 100}, {0, 20}}), row({{0, 20}, {1, 100}}), 50);
  EXPECT_EQ(segcomp(overlap, 0.80).correct, 1);
  const SegcompScore stricter = segcomp(overlap, 0.81);
  EXPECT_EQ(stricter.correct, 0);
  EXPECT_EQ(stricter.missed, 1);
  EXPECT_EQ(stricter.noise, 1);
  EXPECT_NEAR(overlapScore(overlap).mean_iou, 80.0 / 120.0, 1e-12);
}

TEST(Segcomp, OneTrueRegionInTwoHalvesIsOverSegmented) {
  const auto overlap = overlapOf(row({{1, 1000}}), row({{1, 500}, {2, 500}}));
  const SegcompScore score = segcomp(overlap, 0.8);
  EXPECT_EQ(score.correct, 0);
  EXPECT_EQ(score.over_segmented, 1);
  EXPECT_EQ(score.missed + score.noise + score.under_segmented, 0);
  EXPECT_DOUBLE_EQ(f1(overlap, score), 0.0);
}

TEST(Segcomp, TwoTrueRegionsInOneAreUnderSegmented) {
  const auto overlap = overlapOf(row({{1, 500}, {2, 500}}), row({{1, 1000}}));
  const SegcompScore score = segcomp(overlap, 0.8);
  EXPECT_EQ(score.under_segmented, 1);
  EXPECT_EQ(score.missed + score.noise + score.over_segmented + score.correct, 0);
}

TEST(Segcomp, ACorrectDetectionComesBeforeAnInstanceOfOverSegmentation) {
  const auto overlap = overlapOf(row({{1, 1000}}), row({{1, 850}, {2, 150}}));
  const SegcompScore score = segcomp(overlap, 0.8);
  EXPECT_EQ(score.correct, 1);
  EXPECT_EQ(score.over_segmented, 0);
  EXPECT_EQ(score.noise, 1);
  EXPECT_DOUBLE_EQ(f1(overlap, score), 2.0 / 3.0);
}

TEST(Segcomp, SmallTrueRegionsAndWhatIsFoundOnThemAreIgnored) {
  const auto overlap = overlapOf(row({{1, 500}, {2, 399}, {0, 100}}), row({{1, 500}, {2, 399}, {0, 100}}), 400);
  EXPECT_EQ(overlap.true_ids, std::vector<std::int32_t>{1});
  EXPECT_EQ(overlap.found_ids, std::vector<std::int32_t>{1});
  EXPECT_EQ(overlap.ignored_true, 1);
  EXPECT_EQ(overlap.ignored_found, 1);
  EXPECT_DOUBLE_EQ(f1(overlap, segcomp(overlap, 0.8)), 1.0);
  EXPECT_DOUBLE_EQ(overlapScore(overlap).precision, 1.0);
}

TEST(Segcomp, WhatIsFoundWhereTheTruthHasNoPlaneIsNoise) {
  const auto overlap = overlapOf(row({{1, 500}, {0, 500}}), row({{1, 500}, {2, 500}}));
  const SegcompScore score = segcomp(overlap, 0.8);
  EXPECT_EQ(score.correct, 1);
  EXPECT_EQ(score.noise, 1);
  EXPECT_DOUBLE_EQ(overlapScore(overlap).precision, 0.5);
  EXPECT_DOUBLE_EQ(overlapScore(overlap).recall, 1.0);
}

TEST(Segcomp, NothingToFindAndNothingFoundIsPerfect) {
  const auto overlap = overlapOf(row({{0, 10}}), row({{0, 10}}));
  EXPECT_DOUBLE_EQ(f1(overlap, segcomp(overlap, 0.8)), 1.0);
}

TEST(Segcomp, OtherSizesAndTolerancesAreRefused) {
  EXPECT_THROW(overlapOf(row({{0, 10}}), row({{0, 11}})), std::invalid_argument);
  EXPECT_THROW(segcomp({}, 0.5), std::invalid_argument);
  EXPECT_THROW(segcomp({}, 1.01), std::invalid_argument);
}

}  // namespace
}  // namespace ppc
