// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_resolver.h"
#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

const NoiseModel kNoise(SensorModel(), 1.0);
const CoplanarityTolerance kTolerance{0.005, 0.02, 1.0};

// Two walls that meet in a crease, a third that is nowhere, holes, outliers; from a sensor that moves.
struct Walls {
  BeamGrid grid;
  LabelImage truth;
  std::vector<Eigen::Vector3d> planes;

  Walls(int rows, int cols) : grid(forwardBeams(rows, cols, 0.01)) {
    for (auto* origin : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) origin->resize(grid.range.size());
    for (int i = 0; i < grid.size(); ++i) grid.origin_z[i] = 0.001F * static_cast<float>(i / cols);
    const Eigen::Vector3d left(-1.0, 1.0, 0.1), right(-1.0, -1.0, -0.1);
    truth = scan({wall(left, -2.0), wall(right, -2.0)}, grid);
    addNoise(grid, 0.01);
    for (int i = 0; i < grid.size(); ++i) {
      if (i % 7 == 3) grid.range[i] = kNoRange;
      if (i % 11 == 5) grid.range[i] += 0.05F;
      if (i % 29 == 8) grid.range[i] += 0.3F;
    }
    planes = {Eigen::Vector3d::Zero(), left / -2.0, right / -2.0, Eigen::Vector3d(0.2, 0.1, 0.6)};
  }
};

// Resolves a cell as CellResolver says, written plainly. Coordinates are about `center`.
class PlainResolver {
 public:
  PlainResolver(const Walls& walls, const Eigen::Vector3d& center, int middle) : walls_(walls), center_(center) {
    const double range = walls.grid.range[middle];
    direction_ = walls.grid.direction(middle).cast<double>();
    sigma_ = kNoise.sigma(range);
    distance_ = kTolerance.forNoise(sigma_).sigma_distance;
  }

  std::int32_t winner(int row, int col, int reach, std::int32_t unexplained) const {
    std::int32_t winner = unexplained;
    double best = kNoHit;
    for (std::int32_t label = 1; label < static_cast<std::int32_t>(walls_.planes.size()); ++label) {
      if (!(squared(row, col, label) <= 12.0)) continue;
      double sum = 0.0;
      int count = 0;
      for (int r = std::max(0, row - reach); r <= std::min(walls_.grid.rows - 1, row + reach); ++r) {
        for (int c = std::max(0, col - 1); c <= std::min(walls_.grid.cols - 1, col + 1); ++c) {
          if (!walls_.grid.valid(walls_.grid.index(r, c))) continue;
          sum += std::min(9.0, squared(r, c, label));
          ++count;
        }
      }
      const double mean = sum / count, total = mean + std::log(variance(label) / (sigma_ * sigma_));
      if (mean >= 5.0 || total >= best) continue;
      best = total;
      winner = label;
    }
    return winner;
  }

  double squared(int row, int col, std::int32_t label) const {
    const int i = walls_.grid.index(row, col);
    if (!walls_.grid.valid(i)) return kNoHit;
    const Eigen::Vector3d& a = walls_.planes[label];
    const Eigen::Vector3d origin = walls_.grid.origin(i).cast<double>() - center_;
    const double model = (1.0 - a.dot(origin)) / a.dot(walls_.grid.direction(i).cast<double>());
    const double e = walls_.grid.range[i] - model;
    return model > 0.0 ? e * e / variance(label) : kNoHit;
  }

 private:
  double variance(std::int32_t label) const {
    const Eigen::Vector3d& a = walls_.planes[label];
    const double along = a.dot(direction_);
    return sigma_ * sigma_ + distance_ * distance_ * std::min(kMaxSecant2, a.squaredNorm() / (along * along));
  }

  const Walls& walls_;
  Eigen::Vector3d center_, direction_;
  double sigma_ = 0.0, distance_ = 0.0;
};

class CellsOf : public ::testing::TestWithParam<int> {};

TEST_P(CellsOf, AreResolvedAsByPlainArithmetic) {
  const int size = GetParam();
  const Walls walls(13, 31);
  PatchGrid cells = makePatchGrid(walls.grid, size, false);
  for (int& rows : cells.strip_rows) rows = 2 * size;  // windows that reach two rows up and down
  CellResolver resolver(walls.grid, cells, walls.planes, kNoise, kTolerance);
  int left_out = 0, changed = 0;
  for (const bool keep : {false, true}) {
    LabelImage labels = walls.truth;
    for (int i = 0; i < walls.grid.size(); ++i) {
      if (i % 5 != 0) labels.labels[i] = i % 3 == 0 ? 0 : 2;
    }
    const LabelImage before = labels;
    for (const Patch& cell : cells.patches) {
      // The middle of a cell has a measurement here wherever the pixel that is looked for first has one.
      const int width = cell.col_end - cell.col_begin, half = width * (cell.row_end - cell.row_begin) / 2;
      const int middle = walls.grid.index(cell.row_begin + half / width, cell.col_begin + half % width);
      if (!walls.grid.valid(middle)) continue;
      const PlainResolver plain(walls, cells.center, middle);
      resolver.resolve(cell, {1, 2, 3}, 2, keep, labels);
      for (int r = cell.row_begin; r < cell.row_end; ++r) {
        for (int c = cell.col_begin; c < cell.col_end; ++c) {
          const int i = walls.grid.index(r, c);
          const std::int32_t was = before.labels[i];
          const std::int32_t expected = was == 1 ? 1 : plain.winner(r, c, 2, keep ? was : 0);
          EXPECT_EQ(labels.labels[i], expected) << r << ", " << c << ", cells of " << size;
          left_out += expected == 0 ? 1 : 0;
          changed += expected != was ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(left_out, 20);
  EXPECT_GT(changed, 50);
}

INSTANTIATE_TEST_SUITE_P(Widths, CellsOf, ::testing::Values(2, 3, 4, 5, 7, 8));

TEST(CellResolver, ClearsExactlyTheOutliersOfACell) {
  const Walls walls(12, 32);
  PatchGrid cells = makePatchGrid(walls.grid, 4, false);
  weighPatches(kNoise, cells);
  const CellResolver resolver(walls.grid, cells, walls.planes, kNoise, kTolerance);
  int cleared = 0;
  for (const Patch& cell : cells.patches) {
    const int middle = walls.grid.index(cell.row_begin + 2, cell.col_begin);
    if (!walls.grid.valid(middle)) continue;
    const PlainResolver plain(walls, cells.center, middle);
    LabelImage labels{12, 32, std::vector<std::int32_t>(walls.truth.labels.size(), 1)};
    const bool any = resolver.clearOutliers(cell, 1, labels);
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
TEST(CellResolver, ClearsASingleOutlierWhereverItLies) {
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
    const bool any = CellResolver(grid, cells, planes, kNoise, kTolerance).clearOutliers(cells.patches[0], 1, labels);
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
