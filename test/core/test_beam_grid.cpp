// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_grid.h"

#include "polygon_test_tools.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using testing_tools::kDegree;
using testing_tools::noddingScan;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(BeamGrid, PointsFollowTheGeometryOfTheImage) {
  const Eigen::Vector3d lever(0.05, 0.0, 0.08);
  RangeImage image = noddingScan(5, 7, -40 * kDegree, 40 * kDegree, 120 * kDegree, lever);
  for (int i = 0; i < 35; ++i) image.ranges[i] = 1.0F + 0.5F * static_cast<float>(i);
  const BeamGrid grid = toBeamGrid(image);
  EXPECT_TRUE(grid.beams_exact);
  ASSERT_EQ(grid.size(), 35);
  for (int r = 0; r < 5; ++r) {
    for (int c = 0; c < 7; ++c) {
      const double range = image.ranges[grid.index(r, c)], bearing = image.bearing(c);
      const Eigen::Vector3d expected =
          image.line_poses[r] * Eigen::Vector3d(range * std::cos(bearing), range * std::sin(bearing), 0);
      EXPECT_LT((grid.point(grid.index(r, c)).cast<double>() - expected).norm(), 1e-5) << r << ", " << c;
    }
  }
}

TEST(BeamGrid, NoOriginsIfTheLaserStaysAtTheFramesOrigin) {
  EXPECT_TRUE(toBeamGrid(noddingScan(3, 4, -0.1, 0.1, 1.0)).origin_x.empty());
  EXPECT_EQ(toBeamGrid(noddingScan(3, 4, -0.1, 0.1, 1.0, {0.1, 0, 0})).origin_x.size(), 12U);
}

TEST(BeamGrid, ValidityFollowsRep117) {
  RangeImage image = noddingScan(1, 6, 0, 0, 1.0);
  const float inf = std::numeric_limits<float>::infinity();
  image.range_min = 0.1;
  image.range_max = 10.0;
  image.ranges = {kNaN, inf, -inf, 0.05F, 10.5F, 10.0F};
  const BeamGrid grid = toBeamGrid(image);
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(grid.valid(i)) << i;
    EXPECT_NEAR(grid.direction(i).norm(), 1.0F, 1e-6F);  // also where there is no measurement
  }
  EXPECT_TRUE(grid.valid(5));
}

// Knots between columns, more knots than columns, odd numbers of columns: against the definition, in double precision.
TEST(BeamGrid, EveryBeamFollowsThePosesAroundIt) {
  for (const int cols : {1, 2, 5, 16}) {
    for (const int knots : {1, 2, 3, 7}) {
      RangeImage image = noddingScan(2, cols, -0.2, 0.2, 2.0);
      image.poses_per_row = knots;
      image.line_poses.clear();
      for (int k = 0; k < 2 * knots; ++k) {
        Eigen::Isometry3d pose(Eigen::AngleAxisd(0.1 * k, Eigen::Vector3d(0.6, 0.0, 0.8)));
        pose.translation() = Eigen::Vector3d(0.3, 0.01 * k, -0.02 * k);
        image.line_poses.push_back(pose);
      }
      const BeamGrid grid = toBeamGrid(image);
      for (int i = 0; i < grid.size(); ++i) {
        const int row = i / cols, col = i % cols;
        const double at = cols == 1 ? 0.0 : col * (knots - 1.0) / (cols - 1.0);
        const int k = std::min(static_cast<int>(at), std::max(0, knots - 2)), next = std::min(k + 1, knots - 1);
        const Eigen::Matrix4d a = image.line_poses[row * knots + k].matrix();
        const Eigen::Matrix4d pose = a + (at - k) * (image.line_poses[row * knots + next].matrix() - a);
        const double bearing = image.bearing(col);
        const Eigen::Vector3d expected =
            (pose.block<3, 1>(0, 0) * std::cos(bearing) + pose.block<3, 1>(0, 1) * std::sin(bearing)).normalized();
        EXPECT_LT((grid.direction(i).cast<double>() - expected).norm(), 3e-7) << cols << " columns, " << knots << " knots";
        EXPECT_LT((grid.origin(i).cast<double>() - pose.block<3, 1>(0, 3)).norm(), 1e-7);
      }
    }
  }
}

TEST(BeamGrid, MemoryOfAnotherImageMakesNoDifference) {
  RangeImage first = noddingScan(4, 9, -0.2, 0.2, 2.0, {0.1, 0.0, 0.0}), second = noddingScan(3, 7, -0.1, 0.3, 1.0);
  first.ranges.assign(36, 2.0F);
  second.ranges.assign(21, 3.0F);
  BeamGrid grid;
  BeamColumns columns;
  toBeamGrid(first, columns, grid);
  toBeamGrid(second, columns, grid);
  const BeamGrid fresh = toBeamGrid(second);
  EXPECT_EQ(grid.dir_x, fresh.dir_x);
  EXPECT_EQ(grid.dir_y, fresh.dir_y);
  EXPECT_EQ(grid.dir_z, fresh.dir_z);
  EXPECT_EQ(grid.range, fresh.range);
  EXPECT_TRUE(grid.origin_x.empty());
}

TEST(BeamGrid, ThreadsMakeNoDifference) {
  for (const bool moves : {false, true}) {
    RangeImage image = noddingScan(23, 17, -0.5, 0.5, 2.0, {moves ? 0.1 : 0.0, 0.0, 0.0});
    for (std::size_t i = 0; i < image.ranges.size(); ++i)
      image.ranges[i] = i % 5 == 0 ? kNaN : 1.0F + 0.1F * static_cast<float>(i % 7);
    BeamColumns columns;
    BeamGrid one, several;
    toBeamGrid(image, columns, one);
    for (const int threads : {2, 5, 40}) {
      toBeamGrid(image, columns, several, threads);
      EXPECT_EQ(one.dir_x, several.dir_x);
      EXPECT_EQ(one.dir_y, several.dir_y);
      EXPECT_EQ(one.dir_z, several.dir_z);
      EXPECT_EQ(one.origin_x, several.origin_x);
      for (std::size_t i = 0; i < one.range.size(); ++i) {
        EXPECT_TRUE(one.range[i] == several.range[i] || (std::isnan(one.range[i]) && std::isnan(several.range[i]))) << i;
      }
    }
  }
}

// Two knots a row: the pose in between is interpolated at each beam.
TEST(BeamGrid, PoseIsInterpolatedAlongTheRow) {
  RangeImage image = noddingScan(1, 5, 0, 0, 0.5);
  image.poses_per_row = 2;
  const double step = 0.5 * kDegree;
  Eigen::Isometry3d end(Eigen::AngleAxisd(step, Eigen::Vector3d::UnitY()));
  end.translation() = Eigen::Vector3d(0.02, 0.0, 0.0);
  image.line_poses = {Eigen::Isometry3d::Identity(), end};
  image.ranges.assign(5, 4.0F);
  const BeamGrid grid = toBeamGrid(image);
  for (int c = 0; c < 5; ++c) {
    Eigen::Isometry3d pose(Eigen::AngleAxisd(step * c / 4.0, Eigen::Vector3d::UnitY()));
    pose.translation() = Eigen::Vector3d(0.02 * c / 4.0, 0, 0);
    const double bearing = image.bearing(c);
    const Eigen::Vector3d expected = pose * Eigen::Vector3d(4.0 * std::cos(bearing), 4.0 * std::sin(bearing), 0);
    EXPECT_LT((grid.point(c).cast<double>() - expected).norm(), 1e-4) << c;
  }
}

TEST(BeamGrid, InconsistentImageIsRefused) {
  RangeImage image = noddingScan(2, 3, 0, 0.1, 1.0);
  image.ranges.pop_back();
  EXPECT_THROW(toBeamGrid(image), std::invalid_argument);
}

TEST(BeamGridFromPoints, DirectionsComeFromThePointsAndFillTheGaps) {
  // A row of beams over +-0.3 rad; the middle and the last are missing.
  const std::vector<double> bearings{-0.3, -0.15, 0.0, 0.15, 0.3};
  std::vector<float> x, y, z(5, 0.0F);
  for (const double b : bearings) {
    x.push_back(static_cast<float>(2.0 * std::cos(b)));
    y.push_back(static_cast<float>(2.0 * std::sin(b)));
  }
  x[2] = kNaN;
  y[4] = kNaN;
  const BeamGrid grid = beamGridFromPoints(1, 5, x, y, z);
  EXPECT_FALSE(grid.beams_exact);
  EXPECT_NEAR(grid.range[1], 2.0F, 1e-6F);
  EXPECT_FALSE(grid.valid(2));
  EXPECT_FALSE(grid.valid(4));
  for (int c = 0; c < 5; ++c) {
    EXPECT_NEAR(std::atan2(grid.dir_y[c], grid.dir_x[c]), bearings[c], 0.01) << c;  // steps of 0.15 rad, continued linearly
    EXPECT_NEAR(grid.direction(c).norm(), 1.0F, 1e-5F);
  }
}

TEST(BeamGridFromPoints, ViewpointIsTheOriginOfTheBeams) {
  const BeamGrid grid = beamGridFromPoints(1, 2, {3.0F, 1.0F}, {1.0F, 1.0F}, {1.0F, 1.0F}, {1.0F, 1.0F, 1.0F});
  EXPECT_NEAR(grid.range[0], 2.0F, 1e-6F);
  EXPECT_LT((grid.direction(0) - Eigen::Vector3f::UnitX()).norm(), 1e-6F);
  EXPECT_LT((grid.point(0) - Eigen::Vector3f(3, 1, 1)).norm(), 1e-6F);
  EXPECT_FALSE(grid.valid(1));  // on the viewpoint itself
}

TEST(BeamGridFromPoints, RowsAndImagesWithoutPointsHaveDirections) {
  const BeamGrid grid =
      beamGridFromPoints(2, 2, {1.0F, 1.0F, kNaN, kNaN}, {0.0F, 0.1F, 0.0F, 0.0F}, {0.0F, 0.0F, 0.0F, 0.0F});
  EXPECT_LT((grid.direction(2) - grid.direction(0)).norm(), 1e-6F);
  const BeamGrid empty = beamGridFromPoints(1, 2, {kNaN, kNaN}, {kNaN, kNaN}, {kNaN, kNaN});
  EXPECT_EQ(empty.direction(0), Eigen::Vector3f::UnitX());
}

TEST(BeamGridFromPoints, RowsWithoutPointsAreLikeTheNearestWithSome) {
  std::vector<float> x(8, kNaN), y(8, 0.0F), z(8, 0.0F);
  x[1] = x[6] = 2.0F;
  z[1] = 1.0F;
  BeamGrid grid = toBeamGrid(noddingScan(8, 1, -0.1, 0.1, 1.0, {0.1, 0.0, 0.0}));  // of which nothing is left
  beamGridFromPoints(8, 1, x, y, z, Eigen::Vector3f::Zero(), grid);
  EXPECT_FALSE(grid.beams_exact);
  EXPECT_TRUE(grid.origin_x.empty());
  for (int r = 0; r < 8; ++r) EXPECT_EQ(grid.direction(r), grid.direction(r <= 3 ? 1 : 6)) << r;
  EXPECT_NE(grid.direction(1), grid.direction(6));
}

TEST(BeamGridFromPoints, WhatIsAThousandKilometresAwayIsNoMeasurement) {
  const BeamGrid grid =
      beamGridFromPoints(1, 4, {1.0F, 1e17F, 0.9e6F, 1.1e6F}, {0.0F, 0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 0.0F, 0.0F});
  EXPECT_TRUE(grid.valid(0));
  EXPECT_FALSE(grid.valid(1));
  EXPECT_TRUE(grid.valid(2));
  EXPECT_FALSE(grid.valid(3));
}

TEST(BeamGridFromPoints, WrongSizesAreRefused) {
  EXPECT_THROW(beamGridFromPoints(0, 4, {}, {}, {}), std::invalid_argument);
  EXPECT_THROW(beamGridFromPoints(1, 2, {1.0F, 2.0F}, {0.0F}, {0.0F, 0.0F}), std::invalid_argument);
}

}  // namespace
}  // namespace ppc
