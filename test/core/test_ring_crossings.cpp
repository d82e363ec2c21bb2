// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_crossings.h"

#include <gtest/gtest.h>
#include <cmath>

namespace ppc {
namespace {

using Ring = std::vector<Eigen::Vector2d>;

const Ring kSquare{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

TEST(RingCrossings, SimpleRingsApartHaveNone) {
  EXPECT_TRUE(findCrossings({kSquare}).empty());
  EXPECT_TRUE(findCrossings({kSquare, {{0.2, 0.2}, {0.2, 0.8}, {0.8, 0.8}}}).empty());
}

TEST(RingCrossings, BowTieNamesItsTwoEdges) {
  const auto found = findCrossings({{{0, 0}, {1, 1}, {1, 0}, {0, 1}}});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].edge, 0U);
  EXPECT_EQ(found[1].edge, 2U);
}

TEST(RingCrossings, TouchAndNearTouchCount) {
  EXPECT_FALSE(findCrossings({kSquare, {{1.0, 0.5}, {2, 0}, {2, 1}}}).empty());
  EXPECT_FALSE(findCrossings({kSquare, {{1.0 + 0.5 * kRingClearance, 0.5}, {2, 0}, {2, 1}}}).empty());
  EXPECT_TRUE(findCrossings({kSquare, {{1.0 + 2.0 * kRingClearance, 0.5}, {2, 0}, {2, 1}}}).empty());
}

TEST(RingCrossings, SpikeCounts) { EXPECT_FALSE(findCrossings({{{0, 0}, {1, 0}, {1, 1}, {1, 0.5}, {0, 1}}}).empty()); }

TEST(RingCrossings, DegenerateRingCounts) { EXPECT_EQ(findCrossings({{{0, 0}, {1, 0}}}).size(), 2U); }

TEST(RingCrossings, InsideIsInside) {
  const Ring arrow{{0, 0}, {2, 0}, {2, 2}, {1, 0.5}, {0, 2}};
  EXPECT_TRUE(isInside({0.2, 1.0}, arrow));
  EXPECT_FALSE(isInside({1.0, 1.0}, arrow));
  EXPECT_FALSE(isInside({-0.1, 1.0}, arrow));
}

TEST(RingCrossings, LongCircleIsSimple) {
  Ring circle;
  for (int i = 0; i < 20000; ++i) circle.emplace_back(100 * std::cos(i * M_PI / 10000), 100 * std::sin(i * M_PI / 10000));
  EXPECT_TRUE(findCrossings({circle}).empty());
}

}  // namespace
}  // namespace ppc
