// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/boundary_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ppc {
namespace {

// Beams through (1, y, z) on a wall 1 m ahead, 0.01 m apart; columns run along y, rows along z.
BeamGrid wallBeams(int rows, int cols) {
  std::vector<float> x, y, z;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      x.push_back(1.0F);
      y.push_back(0.01F * static_cast<float>(c));
      z.push_back(0.01F * static_cast<float>(r));
    }
  }
  return beamGridFromPoints(rows, cols, x, y, z);
}

PlanarRegion wall() {
  PlanarRegion region;
  region.id = 1;
  region.plane = {-Eigen::Vector3d::UnitX(), -1.0};
  return region;
}

// Label 1 on rows [top, bottom) and columns [left, right).
LabelImage rectangle(int rows, int cols, int top, int bottom, int left, int right) {
  LabelImage image{rows, cols, std::vector<std::int32_t>(static_cast<std::size_t>(rows) * cols, 0)};
  for (int r = top; r < bottom; ++r) {
    for (int c = left; c < right; ++c) image.labels[static_cast<std::size_t>(r) * cols + c] = 1;
  }
  return image;
}

PlanarPolygon box(double y0, double y1, double z0, double z1) {
  PlanarPolygon polygon;
  polygon.id = 5;
  polygon.outer = {{1.0, y1, z0}, {1.0, y0, z0}, {1.0, y0, z1}, {1.0, y1, z1}};
  return polygon;
}

TEST(TrueOutline, RunsBetweenThePixels) {
  const LabelImage truth = rectangle(8, 10, 2, 5, 3, 7);
  const auto outline = trueOutline(wallBeams(8, 10), truth, wall());
  ASSERT_EQ(outline.size(), 14U);  // twice 4 and twice 3 sides of pixels
  for (const auto& p : outline) {
    EXPECT_NEAR(p.x(), 1.0, 1e-6);
    const bool upright = std::abs(p.y() - 0.025) < 1e-4 || std::abs(p.y() - 0.065) < 1e-4;
    const bool level = std::abs(p.z() - 0.015) < 1e-4 || std::abs(p.z() - 0.045) < 1e-4;
    EXPECT_TRUE(upright != level) << p.transpose();
  }
}

TEST(TrueOutline, AtTheBorderOfTheImageItIsHalfAPixelOut) {
  const auto outline = trueOutline(wallBeams(4, 6), rectangle(4, 6, 0, 4, 0, 6), wall());
  ASSERT_EQ(outline.size(), 20U);
  double low = 1.0, high = -1.0;
  for (const auto& p : outline) {
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  EXPECT_NEAR(low, -0.005, 1e-4);
  EXPECT_NEAR(high, 0.055, 1e-4);
}

TEST(TrueOutline, SmallGapsAreNoneOfIt) {
  LabelImage truth = rectangle(8, 10, 1, 7, 1, 9);
  truth.labels[4 * 10 + 5] = 0;
  EXPECT_EQ(trueOutline(wallBeams(8, 10), truth, wall(), 2).size(), 28U);
  EXPECT_EQ(trueOutline(wallBeams(8, 10), truth, wall(), 1).size(), 32U);
}

TEST(BoundaryScore, IsTheMeanDistanceFromTheRings) {
  const BeamGrid beams = wallBeams(8, 10);
  const LabelImage truth = rectangle(8, 10, 2, 5, 3, 7);
  RegionOverlap overlap;
  overlap.true_ids = {1};
  overlap.found_ids = {5};
  SegcompScore matches;
  matches.matches = {{0, 0}};
  const auto error = [&](const std::vector<PlanarPolygon>& polygons) {
    const BoundaryScore score = boundaryScore(beams, truth, {wall()}, polygons, overlap, matches);
    return score.regions == 1 ? score.mean_error : -1.0;
  };
  EXPECT_NEAR(error({box(0.025, 0.065, 0.015, 0.045)}), 0.0, 1e-4);
  // 4 mm too wide on all sides: every point is 4 mm away from its side.
  EXPECT_NEAR(error({box(0.021, 0.069, 0.011, 0.049)}), 0.004, 1e-4);
  // 7 mm too high at the top only: of the 4 of 14 points there, two are 7 mm from the top and two 5 mm from a side.
  EXPECT_NEAR(error({box(0.025, 0.065, 0.015, 0.052)}), (2 * 0.007 + 2 * 0.005) / 14, 1e-4);
  PlanarPolygon other = box(0.025, 0.065, 0.015, 0.045);
  other.id = 6;
  EXPECT_EQ(error({other}), -1.0);
}

TEST(BoundaryScore, AHoleIsAnEdgeToo) {
  const BeamGrid beams = wallBeams(20, 20);
  LabelImage truth = rectangle(20, 20, 2, 18, 2, 18);
  for (int r = 6; r < 14; ++r) {
    for (int c = 6; c < 14; ++c) truth.labels[static_cast<std::size_t>(r) * 20 + c] = 0;
  }
  RegionOverlap overlap;
  overlap.true_ids = {1};
  overlap.found_ids = {5};
  SegcompScore matches;
  matches.matches = {{0, 0}};
  PlanarPolygon polygon = box(0.015, 0.175, 0.015, 0.175);
  const double filled = boundaryScore(beams, truth, {wall()}, {polygon}, overlap, matches).mean_error;
  // 32 of 96 points are the hole's, each 40 mm away from the outer ring.
  EXPECT_NEAR(filled, 0.04 / 3.0, 2e-4);
  polygon.holes.push_back({{1.0, 0.055, 0.055}, {1.0, 0.135, 0.055}, {1.0, 0.135, 0.135}, {1.0, 0.055, 0.135}});
  EXPECT_NEAR(boundaryScore(beams, truth, {wall()}, {polygon}, overlap, matches).mean_error, 0.0, 2e-4);
}

}  // namespace
}  // namespace ppc
