// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/hole_score.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

// A picture of characters: '.' is 0, digits are labels.
LabelImage picture(const std::vector<std::string>& rows) {
  LabelImage image{static_cast<int>(rows.size()), static_cast<int>(rows[0].size()), {}};
  for (const std::string& row : rows) {
    for (const char c : row) image.labels.push_back(c == '.' ? 0 : c - '0');
  }
  return image;
}

TEST(HolesOf, FindsWhatARegionEncloses) {
  const std::vector<Hole> holes = holesOf(picture({"1111111",  //
                                                   "1..1221",  //
                                                   "1..1221",  //
                                                   "1111111"}),
                                          1, 1);
  ASSERT_EQ(holes.size(), 2U);
  EXPECT_EQ(holes[0], (Hole{8, 9, 15, 16}));
  EXPECT_EQ(holes[1], (Hole{11, 12, 18, 19}));
}

TEST(HolesOf, WhatReachesTheOutsideOrTheBorderOfTheImageIsNone) {
  EXPECT_TRUE(holesOf(picture({"11.111", "1....1", "111111"}), 1, 1).empty());
  EXPECT_TRUE(holesOf(picture({"111111", "1.....", "111111"}), 1, 1).empty());
  EXPECT_TRUE(holesOf(picture({"......", "..11..", "......"}), 1, 1).empty());
  EXPECT_TRUE(holesOf(picture({"111"}), 5, 1).empty());  // no such region
}

TEST(HolesOf, ADiagonalGapKeepsAHoleClosed) {
  const std::vector<Hole> holes = holesOf(picture({".111", "1..1", "1111"}), 1, 1);
  ASSERT_EQ(holes.size(), 1U);
  EXPECT_EQ(holes[0], (Hole{5, 6}));
}

TEST(HolesOf, LeavesOutSmallOnes) {
  const LabelImage image = picture({"111111", "1.1..1", "111111"});
  EXPECT_EQ(holesOf(image, 1, 1).size(), 2U);
  EXPECT_EQ(holesOf(image, 1, 2).size(), 1U);
  EXPECT_EQ(holesOf(image, 1, 3).size(), 0U);
}

TEST(HoleScore, CountsHolesThatTheFoundRegionHasToo) {
  const LabelImage truth = picture({"11111111111",  //
                                    "1...1...1..",  //
                                    "1...1...1..",  //
                                    "11111111111"});
  const LabelImage found = picture({"77777777777",  //
                                    "77..7777777",  // IoU 4 / 6 with the first hole, nothing at the second
                                    "77..7777777",  //
                                    "77777777777"});
  const HoleScore score = holeScore(truth, found, overlapOf(truth, found, 10), 5);
  EXPECT_EQ(score.true_holes, 2);  // what is open on the right is none
  EXPECT_EQ(score.found_holes, 1);
  const HoleScore perfect = holeScore(truth, truth, overlapOf(truth, truth, 10), 5);
  EXPECT_EQ(perfect.found_holes, 2);
  EXPECT_EQ(perfect.found_openings, 2);
}

TEST(HoleScore, ANotchIsAnOpeningButNoHole) {
  const LabelImage truth = picture({"11111111111",  //
                                    "1...1...111",  //
                                    "1...1...111",  //
                                    "11111111111"});
  const LabelImage notch = picture({"77.77777777",  // the first hole is open to the top, the second filled
                                    "7...7777777",  //
                                    "7...7777777",  //
                                    "77777777777"});
  const HoleScore score = holeScore(truth, notch, overlapOf(truth, notch, 10), 5);
  EXPECT_EQ(score.true_holes, 2);
  EXPECT_EQ(score.found_holes, 0);
  EXPECT_EQ(score.found_openings, 1);
  const LabelImage half = picture({"77.........",  // left out, but hardly bounded
                                   "7..........",  //
                                   "7..........",  //
                                   "77........."});
  EXPECT_EQ(holeScore(truth, half, overlapOf(truth, half, 10), 5).found_openings, 0);
}

TEST(HoleScore, AHoleOfAnotherShapeAndARegionThatWasMissedAreNotRecalled) {
  const LabelImage truth = picture({"111111111", "1...1...1", "111111111"});
  const LabelImage small = picture({"222222222", "2.22222.2", "222222222"});  // IoU 1 / 3 each
  EXPECT_EQ(holeScore(truth, small, overlapOf(truth, small, 10), 2).found_holes, 0);
  const LabelImage nothing = picture({".........", ".........", "........."});
  const HoleScore score = holeScore(truth, nothing, overlapOf(truth, nothing, 10), 2);
  EXPECT_EQ(score.true_holes, 2);
  EXPECT_EQ(score.found_holes, 0);
}

}  // namespace
}  // namespace ppc
