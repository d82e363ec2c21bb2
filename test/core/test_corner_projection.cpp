// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/corner_projection.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

// The beam through a corner, written plainly: at (row, col) in pixels, whose centres are at whole numbers.
Eigen::Vector3d between(const BeamGrid& grid, double row, double col, bool origins) {
  const int r = std::clamp(static_cast<int>(std::floor(row)), 0, grid.rows - 2);
  const int c = std::clamp(static_cast<int>(std::floor(col)), 0, grid.cols - 2);
  const auto at = [&](int i) -> Eigen::Vector3d { return (origins ? grid.origin(i) : grid.direction(i)).cast<double>(); };
  const double fr = row - r, fc = col - c;
  return (1.0 - fr) * ((1.0 - fc) * at(grid.index(r, c)) + fc * at(grid.index(r, c + 1))) +
         fr * ((1.0 - fc) * at(grid.index(r + 1, c)) + fc * at(grid.index(r + 1, c + 1)));
}

Eigen::Vector3d hit(const BeamGrid& grid, const Plane& plane, double row, double col) {
  const Eigen::Vector3d origin = between(grid, row, col, true), direction = between(grid, row, col, false);
  return origin + plane.rangeAlong(origin, direction) * direction;
}

struct Inclined {
  BeamGrid grid = forwardBeams(6, 9, 0.02);
  PlanarRegion region;
  LabelImage labels{6, 9, std::vector<std::int32_t>(54, 1)};

  explicit Inclined(bool moving) {
    if (moving) {
      for (auto* origin : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) origin->resize(54);
      for (int i = 0; i < 54; ++i) {
        grid.origin_x[i] = 0.002F * static_cast<float>(i / 9);
        grid.origin_y[i] = -0.001F * static_cast<float>(i);
        grid.origin_z[i] = 0.003F * static_cast<float>(i % 9);
      }
    }
    region.id = 1;
    region.plane.normal = Eigen::Vector3d(-1.0, 0.3, -0.2).normalized();
    region.plane.d = -2.0;
    for (int i = 0; i < 54; ++i) {
      grid.range[i] =
          static_cast<float>(region.plane.rangeAlong(grid.origin(i).cast<double>(), grid.direction(i).cast<double>()));
    }
    region.centroid = grid.point(grid.index(3, 4)).cast<double>();
  }
};

class CornerProjectionOf : public ::testing::TestWithParam<bool> {};

TEST_P(CornerProjectionOf, CornersHitThePlaneWhereTheirBeamsDo) {
  const Inclined scene(GetParam());
  CornerProjection projection(scene.grid, scene.labels, scene.region);
  std::vector<PixelCorner> corners;  // an odd number, all sides of the image among them
  for (int r = 0; r <= 6; ++r) {
    for (int c = 0; c <= 8; ++c) corners.push_back({r, c, 0, 0});
  }
  corners.push_back({3, 4, 1, -1});
  corners.push_back({2, 9, 0, 0});
  ASSERT_EQ(corners.size() % 2, 1U);
  std::vector<OutlinePoint> points(corners.size());
  projection.project(corners.data(), corners.size(), points.data());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double row = corners[i].row - 0.5 + 0.25 * corners[i].pull_row,
                 col = corners[i].col - 0.5 + 0.25 * corners[i].pull_col;
    const Eigen::Vector3d expected = hit(scene.grid, scene.region.plane, row, col);
    EXPECT_LT((projection.lift(points[i].point) - expected).norm(), 1e-8) << "corner " << i;
    constexpr double kSmall = 1e-5;  // pixels, within which the beams are linear between the same four
    const Eigen::Vector3d above = hit(scene.grid, scene.region.plane, row + kSmall, col);
    const Eigen::Vector3d beside = hit(scene.grid, scene.region.plane, row, col + kSmall);
    const Eigen::Vector3d row_step = projection.lift(points[i].row_step.cast<double>()) - projection.lift({0.0, 0.0});
    const Eigen::Vector3d col_step = projection.lift(points[i].col_step.cast<double>()) - projection.lift({0.0, 0.0});
    EXPECT_LT((row_step - (above - expected) / kSmall).norm(), 1e-5) << "corner " << i;
    EXPECT_LT((col_step - (beside - expected) / kSmall).norm(), 1e-5) << "corner " << i;
  }
  EXPECT_EQ(projection.limited(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Origins, CornerProjectionOf, ::testing::Bool());

TEST(CornerProjection, IsTheSameForOneCornerAsForMany) {
  const Inclined scene(true);
  const std::vector<PixelCorner> corners = {{0, 0, 0, 0}, {1, 1, 0, 0}, {6, 9, 0, 0}};
  CornerProjection together(scene.grid, scene.labels, scene.region), apart(scene.grid, scene.labels, scene.region);
  std::vector<OutlinePoint> all(corners.size());
  together.project(corners.data(), corners.size(), all.data());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    OutlinePoint one;
    apart.project(&corners[i], 1, &one);
    EXPECT_EQ(one.point, all[i].point);
    EXPECT_EQ(one.row_step, all[i].row_step);
    EXPECT_EQ(one.col_step, all[i].col_step);
  }
}

TEST(CornerProjection, StaysNearTheRangesMeasuredAround) {
  Inclined scene(false);
  for (float& range : scene.grid.range) range *= 0.5F;  // points far before the plane
  CornerProjection projection(scene.grid, scene.labels, scene.region);
  const PixelCorner corner{3, 4, 0, 0};
  OutlinePoint point;
  projection.project(&corner, 1, &point);
  EXPECT_EQ(projection.limited(), 1U);
  const double longest = std::max({scene.grid.range[scene.grid.index(2, 3)], scene.grid.range[scene.grid.index(2, 4)],
                                   scene.grid.range[scene.grid.index(3, 3)], scene.grid.range[scene.grid.index(3, 4)]});
  const Eigen::Vector3d beam = between(scene.grid, 2.5, 3.5, false).normalized();
  const Eigen::Vector3d limit = 1.25 * longest * beam;
  const Eigen::Vector3d& n = scene.region.plane.normal;
  const Eigen::Vector3d expected = limit - scene.region.plane.signedDistance(limit) * n;  // onto the plane
  EXPECT_LT((projection.lift(point.point) - expected).norm(), 1e-6);
}

}  // namespace
}  // namespace ppc
