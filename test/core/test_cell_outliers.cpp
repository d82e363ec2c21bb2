// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_outliers.h"
#include "patch_plane_clustering/core/clustering.h"

#include "cell_test_tools.h"

#include <gtest/gtest.h>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

TEST(CellOutliers, ClearsExactlyTheOutliersOfACell) {
  const Walls walls(12, 32);
  PatchGrid cells = makePatchGrid(walls.grid, 4, false);
  weighPatches(kNoise, cells);
  const CellOutliers outliers(walls.grid, cells.center, walls.planes, kNoise, kTolerance);
  int cleared = 0;
  for (const Patch& cell : cells.patches) {
    const int middle = walls.grid.index(cell.row_begin + 2, cell.col_begin);
    if (!walls.grid.valid(middle)) continue;
    const PlainResolver plain(walls, cells.center, middle);
    LabelImage labels{12, 32, std::vector<std::int32_t>(walls.truth.labels.size(), 1)};
    const bool any = outliers.clear(cell, 1, labels);
    bool expected_any = false;
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int c = cell.col_begin; c < cell.col_end; ++c) {
        const int i = walls.grid.index(r, c);
        if (!walls.grid.valid(i)) continue;  // has no label to lose
        const bool outlier = plain.squared(r, c, 1) > 36.0;
        EXPECT_EQ(labels.labels[i], outlier ? 0 : 1) << r << ", " << c;
        expected_any = expected_any || outlier;
      }
    }
    EXPECT_EQ(any, expected_any);
    cleared += expected_any ? 1 : 0;
  }
  EXPECT_GT(cleared, 5);
  EXPECT_LT(cleared, static_cast<int>(cells.patches.size()) - 5);
}

// The sums of a cell alone must not hide it, whether it lies near the sensor, just off the wall or far behind.
TEST(CellOutliers, ClearsASingleOutlierWhereverItLies) {
  const Eigen::Vector3d normal(-1.0, 2.0, 0.2);
  BeamGrid clean = forwardBeams(4, 4, 0.01);
  scan({wall(normal, -2.0)}, clean);
  const std::vector<Eigen::Vector3d> planes = {Eigen::Vector3d::Zero(), normal / -2.0};
  const double sigma = kNoise.sigma(clean.range[5]), distance = kTolerance.forNoise(sigma).sigma_distance;
  const double along = planes[1].dot(clean.direction(8).cast<double>());  // the middle
  const double limit = 6.0 * std::sqrt(sigma * sigma + distance * distance * planes[1].squaredNorm() / (along * along));
  const double range = clean.range[5];
  const auto isCleared = [&](double at) {
    BeamGrid grid = clean;
    grid.range[5] = static_cast<float>(at);
    PatchGrid cells = makePatchGrid(grid, 4, false);
    weighPatches(kNoise, cells);
    LabelImage labels{4, 4, std::vector<std::int32_t>(16, 1)};
    const bool any = CellOutliers(grid, cells.center, planes, kNoise, kTolerance).clear(cells.patches[0], 1, labels);
    EXPECT_EQ(any, labels.labels[5] == 0);
    return any;
  };
  for (const double at : {0.001, 0.02, 0.1, 0.3 * range, 0.9 * range, range - 1.02 * limit, range + 1.02 * limit, 40.0}) {
    EXPECT_TRUE(isCleared(at)) << at << " of " << range;
  }
  for (const double at : {range - 0.98 * limit, range, range + 0.98 * limit}) EXPECT_FALSE(isCleared(at)) << at;
}

}  // namespace
}  // namespace ppc
