// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/contours.h"

#include <gtest/gtest.h>
#include <random>
#include <set>
#include <string>
#include <tuple>

namespace ppc {
namespace {

LabelImage labelsFrom(const std::vector<std::string>& lines) {
  LabelImage labels{static_cast<int>(lines.size()), static_cast<int>(lines.front().size()), {}};
  for (const auto& line : lines) {
    for (const char c : line) labels.labels.push_back(c == '.' ? 0 : c - '0');
  }
  return labels;
}

TEST(Contours, OnePixelIsASquareWithThePixelOnTheRight) {
  const PixelContours contours = traceContours(labelsFrom({"...", ".7.", "..."}));
  ASSERT_EQ(contours.rings.size(), 1U);
  EXPECT_EQ(contours.rings[0].label, 7);
  EXPECT_EQ(contours.rings[0].pixels, 1);
  EXPECT_FALSE(contours.rings[0].hole);
  std::vector<std::pair<int, int>> corners;
  for (const auto& c : contours.corners) corners.emplace_back(c.row, c.col);
  EXPECT_EQ(corners, (std::vector<std::pair<int, int>>{{1, 1}, {1, 2}, {2, 2}, {2, 1}}));
}

TEST(Contours, HoleBelongsToTheComponentAroundIt) {
  const PixelContours contours = traceContours(labelsFrom({"1.11111", "..1...1", "..1.2.1", "..11111"}));
  ASSERT_EQ(contours.rings.size(), 4U);
  const PixelRing& lone = contours.rings[0];
  const PixelRing& frame = contours.rings[1];
  const PixelRing& hole = contours.rings[2];
  const PixelRing& island = contours.rings[3];
  EXPECT_EQ(lone.pixels, 1);
  EXPECT_EQ(frame.pixels, 20);
  EXPECT_FALSE(frame.hole);
  EXPECT_TRUE(hole.hole);
  EXPECT_EQ(hole.pixels, 6);  // the island included
  EXPECT_EQ(hole.component, frame.component);
  EXPECT_EQ(island.label, 2);
  EXPECT_NE(island.component, frame.component);
}

TEST(Contours, DiagonalTouchSeparates) {
  const PixelContours contours = traceContours(labelsFrom({"1.", ".1"}));
  ASSERT_EQ(contours.rings.size(), 2U);
  EXPECT_EQ(contours.components, 2);
  // Both pass the corner in the middle, each pulled towards its own pixel.
  std::set<std::tuple<int, int, int, int>> middle;
  for (const auto& c : contours.corners) {
    if (c.row == 1 && c.col == 1) middle.insert({c.row, c.col, c.pull_row, c.pull_col});
  }
  EXPECT_EQ(middle, (std::set<std::tuple<int, int, int, int>>{{1, 1, -1, -1}, {1, 1, 1, 1}}));
}

TEST(Contours, BackgroundConnectsAcrossDiagonals) {
  // The gap in the middle meets the outside at a corner only: it is no hole.
  const PixelContours contours = traceContours(labelsFrom({"1111", "11.1", "111.", "1111"}));
  ASSERT_EQ(contours.rings.size(), 1U);
  EXPECT_EQ(contours.rings[0].pixels, 14);
  // Two gaps that meet at a corner are one hole.
  const PixelContours inner = traceContours(labelsFrom({"11111", "1.111", "11.11", "11111"}));
  ASSERT_EQ(inner.rings.size(), 2U);
  EXPECT_EQ(inner.rings[1].pixels, 2);
}

TEST(Contours, NothingFromNothing) {
  EXPECT_TRUE(traceContours(labelsFrom({"...", "..."})).rings.empty());
  EXPECT_TRUE(traceContours(LabelImage{}).rings.empty());
}

// Every side between two labels is passed once for each label, and the rings enclose exactly the labelled pixels.
TEST(Contours, RandomLabelsAreCoveredExactly) {
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    LabelImage labels{23, 31, {}};
    for (int i = 0; i < 23 * 31; ++i) labels.labels.push_back(static_cast<int>(random() % 3U));
    const PixelContours contours = traceContours(labels);
    long long enclosed = 0, labelled = 0;
    std::set<std::tuple<int, int, int, int>> sides;
    std::set<std::tuple<int, int, int, int>> visits;
    for (const PixelRing& ring : contours.rings) {
      enclosed += ring.hole ? -ring.pixels : ring.pixels;
      for (std::size_t i = ring.begin; i < ring.end; ++i) {
        const PixelCorner& a = contours.corners[i];
        const PixelCorner& b = contours.corners[i + 1 == ring.end ? ring.begin : i + 1];
        ASSERT_EQ(std::abs(a.row - b.row) + std::abs(a.col - b.col), 1);
        ASSERT_TRUE(sides.insert({a.row, a.col, b.row, b.col}).second) << "side passed twice";
        const bool first_visit = visits.insert({a.row, a.col, a.pull_row, a.pull_col + 10 * ring.label}).second;
        ASSERT_TRUE(first_visit) << "corner touched twice";
      }
    }
    std::size_t expected = 0;
    const auto at = [&](int r, int c) { return r < 0 || c < 0 || r >= 23 || c >= 31 ? 0 : labels.labels[r * 31 + c]; };
    for (int r = 0; r < 23; ++r) {
      for (int c = 0; c < 31; ++c) {
        if (at(r, c) == 0) continue;
        ++labelled;
        for (const auto& [dr, dc] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
          expected += at(r + dr, c + dc) != at(r, c) ? 1 : 0;
      }
    }
    EXPECT_EQ(enclosed, labelled);
    EXPECT_EQ(sides.size(), expected);
  }
}

}  // namespace
}  // namespace ppc
