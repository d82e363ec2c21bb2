// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/point_square.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kSize = 200;

BeamGrid obliqueWall() {
  BeamGrid grid = forwardBeams(kSize, kSize, 0.003);
  scan({wall({-1.0, 0.4, 0.2}, -3.0)}, grid);
  return grid;
}

// Means over many squares.
struct Means {
  double squares = 0.0, rows = 0.0, columns = 0.0;

  explicit Means(const BeamGrid& grid, int stride = 1) {
    int count = 0;
    for (int row = 16; row < kSize - 16; row += 4) {
      for (int col = 16; col < kSize - 16; col += 4) {
        const auto square = PointSquare::around(grid, grid.index(row, col), stride, stride);
        if (!square) continue;
        squares += square->residual() * square->residual();
        rows += square->alongRows();
        columns += square->alongColumns();
        ++count;
      }
    }
    for (double* sum : {&squares, &rows, &columns}) *sum /= count;
  }
};

TEST(PointSquare, ResidualsAreTheNoiseHoweverFarPointsLieApart) {
  BeamGrid grid = obliqueWall();
  EXPECT_LT(std::sqrt(Means(grid, 8).squares), 1e-4);  // what the ridge of solvePlane() leaves
  addNoise(grid, 0.01);
  EXPECT_NEAR(std::sqrt(Means(grid).squares), 0.01, 2e-4);
  EXPECT_NEAR(std::sqrt(Means(grid, 8).squares), 0.01, 2e-4);
}

TEST(PointSquare, CorrelationsTellAlongWhatErrorsAreAlike) {
  BeamGrid independent = obliqueWall(), rows = independent, around = independent;
  addNoise(independent, 0.01);
  const Means none(independent);
  EXPECT_NEAR(none.rows, -0.18, 0.04);
  EXPECT_NEAR(none.columns, -0.18, 0.04);
  addNoise(rows, 0.01, 0.0, 0.8);
  const Means lines(rows);
  EXPECT_GT(lines.rows, 0.2);
  EXPECT_LT(lines.columns, -0.2);
  addSmoothNoise(around, 0.01, 1.0);
  const Means both(around);
  EXPECT_GT(both.rows, 0.0);
  EXPECT_GT(both.columns, 0.0);
}

TEST(PointSquare, LiesAroundItsPixelAndNeedsAllPoints) {
  BeamGrid grid = obliqueWall();
  EXPECT_TRUE(PointSquare::around(grid, grid.index(1, 1)));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(0, 1)));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(1, 0)));
  EXPECT_TRUE(PointSquare::around(grid, grid.index(kSize - 3, kSize - 3)));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(kSize - 2, kSize - 3)));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(kSize - 3, kSize - 2)));
  EXPECT_TRUE(PointSquare::around(grid, grid.index(6, 1), 4, 1));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(5, 1), 4, 1));
  grid.range[grid.index(50, 60)] = kNoRange;
  EXPECT_FALSE(PointSquare::around(grid, grid.index(49, 59)));
  EXPECT_FALSE(PointSquare::around(grid, grid.index(51, 61)));
  EXPECT_TRUE(PointSquare::around(grid, grid.index(52, 61)));
}

TEST(PointSquare, OfPointsThatAreNotOffIsNotCorrelated) {
  const BeamGrid grid = obliqueWall();
  for (const int pixel : {grid.index(20, 30), grid.index(100, 150)}) {
    const auto square = PointSquare::around(grid, pixel);
    ASSERT_TRUE(square);
    EXPECT_EQ(square->alongRows(), 0.0);
    EXPECT_EQ(square->alongColumns(), 0.0);
  }
}

}  // namespace
}  // namespace ppc
