// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_loops.h"

#include "patch_plane_clustering/core/ring_crossings.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <vector>

namespace ppc {
namespace {

LoopMemory memory;  // one ring after the other uses it

std::vector<OutlinePoint> ringOf(const std::vector<Eigen::Vector2d>& points) {
  std::vector<OutlinePoint> ring(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) ring[i].point = points[i];
  return ring;
}

std::vector<Eigen::Vector2d> pointsOf(const std::vector<OutlinePoint>& ring) {
  std::vector<Eigen::Vector2d> points;
  for (const OutlinePoint& p : ring) points.push_back(p.point);
  return points;
}

// Outline of -1 < v < 1 and from < u < 1 where (u, v) lies at (u, u v), as lines that meet at u = 0.
std::vector<OutlinePoint> throughPole(double from) {
  constexpr int kSteps = 20;
  std::vector<OutlinePoint> ring;
  const auto add = [&](double u, double v) {
    ring.push_back({{u, u * v}, Eigen::Vector2d(0.0, u).cast<float>(), Eigen::Vector2d(1.0, v).cast<float>()});
  };
  for (int k = 0; k < kSteps; ++k) add(from + (1.0 - from) * k / kSteps, -1.0);
  for (int k = 0; k < kSteps; ++k) add(1.0, -1.0 + 2.0 * k / kSteps);
  for (int k = 0; k < kSteps; ++k) add(1.0 - (1.0 - from) * k / kSteps, 1.0);
  for (int k = 0; k < kSteps; ++k) add(from, 1.0 - 2.0 * k / kSteps);
  return ring;
}

TEST(RingLoops, RingThroughThePoleFoldsOver) {
  EXPECT_TRUE(foldsOver(throughPole(-1.0), 0.02));
  EXPECT_TRUE(foldsOver(throughPole(-0.213), 0.02));  // 0.045 of the larger loop
  EXPECT_FALSE(foldsOver(throughPole(-0.1), 0.02));   // 0.01
  EXPECT_FALSE(foldsOver(throughPole(0.1), 0.0));
  std::vector<OutlinePoint> ring = throughPole(-1.0);
  std::rotate(ring.begin(), ring.begin() + 17, ring.end());
  EXPECT_TRUE(foldsOver(ring, 0.02));
  std::reverse(ring.begin(), ring.end());
  EXPECT_TRUE(foldsOver(ring, 0.02));
}

TEST(RingLoops, RingOfTwoHandsWithoutANarrowPlaceDoesNotFoldOver) {
  std::vector<OutlinePoint> ring = throughPole(0.0);
  for (std::size_t i = 0; i < 15; ++i) ring[i].row_step = -ring[i].row_step;  // footprints alone do not make a fold
  EXPECT_FALSE(foldsOver(ring, 0.02));
}

TEST(RingLoops, SimpleRingStays) {
  auto ring = ringOf({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  EXPECT_FALSE(cutLoops(ring, 1.0, memory));
  EXPECT_EQ(ring.size(), 4U);
}

TEST(RingLoops, SpikeWithoutAreaGoes) {
  auto ring = ringOf({{0, 0}, {1, 0}, {1, 0.5}, {3, 0.5}, {1, 0.5 + 4e-6}, {1, 1}, {0, 1}});
  ASSERT_TRUE(cutLoops(ring, 1e-4, memory));
  EXPECT_TRUE(findCrossings({pointsOf(ring)}).empty());
  EXPECT_NEAR(signedArea(ring.data(), ring.size()), 1.0, 1e-4);
}

TEST(RingLoops, SmallLoopGoesAndLargeOneStays) {
  // The upper right corner is passed in a loop of 0.1 m, turning the other way.
  const std::vector<Eigen::Vector2d> points{{0, 0}, {1, 0}, {1, 0.9}, {1, 1.1}, {1.1, 1.1}, {1.1, 1.0}, {0.9, 1}, {0, 1}};
  auto ring = ringOf(points);
  EXPECT_FALSE(cutLoops(ring, 1e-3, memory));
  EXPECT_EQ(pointsOf(ring), points);
  ASSERT_TRUE(cutLoops(ring, 0.05, memory));
  EXPECT_TRUE(findCrossings({pointsOf(ring)}).empty());
  EXPECT_NEAR(signedArea(ring.data(), ring.size()), 1.0, 0.02);
}

TEST(RingLoops, LoopAcrossTheRingsStartGoes) {
  auto ring = ringOf({{1.1, 1.1}, {1.1, 1.0}, {0.9, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 0.9}, {1, 1.1}});
  ASSERT_TRUE(cutLoops(ring, 0.05, memory));
  EXPECT_TRUE(findCrossings({pointsOf(ring)}).empty());
  EXPECT_NEAR(signedArea(ring.data(), ring.size()), 1.0, 0.02);
}

TEST(RingLoops, RepeatsGoAlsoAcrossTheStart) {
  auto ring = ringOf({{0, 0}, {1, 0}, {1, 1e-6}, {1, 1}, {0, 1}, {1e-6, 0}});
  dropRepeats(ring);
  EXPECT_EQ(pointsOf(ring), (std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
}

}  // namespace
}  // namespace ppc
