// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/outline_excess.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <random>

namespace ppc {
namespace {

// As the header defines it, step by step.
double reference(const OutlinePoint& p, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                 const OutlineTolerance& tolerance) {
  const Eigen::Vector2d edge = to - from;
  const double along = edge.norm() > 0.0 ? std::clamp((p.point - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0) : 0.0;
  const Eigen::Vector2d away = p.point - from - along * edge;
  const double distance = away.norm();
  if (distance == 0.0) return 0.0;
  double allowed = tolerance.metres;
  if (distance > 0.5 * tolerance.metres) {
    const Eigen::Vector2d unit = away / distance;
    allowed = std::max(allowed, tolerance.pixels * (std::abs(unit.dot(p.row_step.cast<double>())) +
                                                    std::abs(unit.dot(p.col_step.cast<double>()))));
  }
  return distance * distance / (allowed * allowed);
}

std::vector<OutlinePoint> randomOutline(int size) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> spread(-1.0, 1.0);
  std::vector<OutlinePoint> points(static_cast<std::size_t>(size));
  for (OutlinePoint& p : points) {
    p.point = {spread(random), 0.1 * spread(random)};
    p.row_step = Eigen::Vector2d(0.05 * spread(random), 0.05 * spread(random)).cast<float>();
    p.col_step = Eigen::Vector2d(0.05 * spread(random), 0.05 * spread(random)).cast<float>();
  }
  return points;
}

TEST(OutlineExcess, IsSquareOfDistanceOverTolerance) {
  const OutlinePoint point{{0.5, 0.06}, {0.0, 0.0}, {0.0, 0.0}};
  const OutlineExcess excess(&point, 1, {0.02, 1.0});
  EXPECT_NEAR(excess.at(0, {0, 0}, {1, 0}), 9.0, 1e-6);
  EXPECT_NEAR(excess.at(0, {0, 0}, {0, 0}), (0.25 + 0.0036) / 0.0004, 1e-6);  // an edge without length is a point
  EXPECT_EQ(excess.at(0, {0.5, 0.06}, {0.5, 0.06}), 0.0);
}

TEST(OutlineExcess, FootprintWidensTheTolerance) {
  const OutlinePoint point{{0.5, 0.06}, {0.0, 0.03}, {0.1, 0.0}};  // 3 cm across the edge
  EXPECT_NEAR(OutlineExcess(&point, 1, {0.02, 1.0}).at(0, {0, 0}, {1, 0}), 4.0, 1e-6);
  EXPECT_NEAR(OutlineExcess(&point, 1, {0.02, 2.0}).at(0, {0, 0}, {1, 0}), 1.0, 1e-6);
  EXPECT_NEAR(OutlineExcess(&point, 1, {0.2, 2.0}).at(0, {0, 0}, {1, 0}), 0.09, 1e-6);  // close by, it does not count
}

TEST(OutlineExcess, FarthestAgreesWithReference) {
  const OutlineTolerance tolerance{0.02, 1.0};
  const std::vector<OutlinePoint> points = randomOutline(201);
  const OutlineExcess excess(points.data(), points.size(), tolerance);
  // Short and long stretches, odd and even, and some that go on over the ring's end.
  const std::vector<std::pair<std::size_t, std::size_t>> stretches{{0, 2}, {3, 6}, {0, 66}, {0, 200}, {10, 203}, {150, 350}};
  for (const auto& [first, last] : stretches) {
    const Eigen::Vector2d from = points[first % 201].point, to = points[last % 201].point;
    std::pair<std::size_t, double> expected{first, -1.0};
    for (std::size_t k = first + 1; k < last; ++k) {
      const double e = reference(points[k % 201], from, to, tolerance);
      if (e > expected.second) expected = {k, e};
    }
    const auto [corner, worst] = excess.farthest(first, last, from, to);
    EXPECT_EQ(corner, expected.first) << first << " to " << last;
    EXPECT_NEAR(worst, expected.second, 1e-9 * expected.second) << first << " to " << last;
    // Corners that do not count change nothing for those that do.
    const auto below = std::pair(first, -1.0);
    for (const double share : {0.0, 0.3, 0.999999, 1.0, 2.0}) {
      EXPECT_EQ(excess.farthest(first, last, from, to, share * worst), share < 1.0 ? std::pair(corner, worst) : below);
    }
  }
}

// Far from the plane's origin too, where single precision has few digits left.
TEST(OutlineExcess, FindsCornersJustAboveTheLeastThatCounts) {
  for (const double away : {0.0, 30.0, 1e4}) {
    std::vector<OutlinePoint> points(40);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].point = {away + 0.1 * static_cast<double>(i), -away};
    points[0].point.y() = points[39].point.y() = -away;
    points[23].point.y() += 0.02 * (1.0 + 1e-8);
    const OutlineExcess excess(points.data(), points.size(), {0.02, 1.0});
    const auto [corner, worst] = excess.farthest(0, 39, points[0].point, points[39].point, 1.0);
    EXPECT_EQ(corner, 23U) << away;
    EXPECT_GT(worst, 1.0);
    points[23].point.y() -= 0.02 * 2e-8;
    EXPECT_EQ(
        OutlineExcess(points.data(), points.size(), {0.02, 1.0}).farthest(0, 39, points[0].point, points[39].point, 1.0),
        std::pair(std::size_t{0}, -1.0));
  }
}

TEST(OutlineExcess, NeighboursHaveNothingBetween) {
  const std::vector<OutlinePoint> points = randomOutline(8);
  const OutlineExcess excess(points.data(), points.size(), {0.02, 1.0});
  const auto [corner, worst] = excess.farthest(3, 4, points[3].point, points[4].point);
  EXPECT_EQ(corner, 3U);
  EXPECT_EQ(worst, -1.0);
}

}  // namespace
}  // namespace ppc
