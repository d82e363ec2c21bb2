// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_grid.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <numeric>
#include <set>

namespace ppc {
namespace {

using namespace testing_tools;

BeamGrid frontalWall(int rows, int cols, double step = 0.01) {
  BeamGrid grid = forwardBeams(rows, cols, step);
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  return grid;
}

// Every pixel lies in the patch that patchAt() names, and in that one only.
void expectPartition(const PatchGrid& patches) {
  std::vector<int> covered(static_cast<std::size_t>(patches.rows) * patches.cols, 0);
  for (std::size_t k = 0; k < patches.patches.size(); ++k) {
    const Patch& patch = patches.patches[k];
    for (int r = patch.row_begin; r < patch.row_end; ++r) {
      for (int c = patch.col_begin; c < patch.col_end; ++c) {
        ++covered[static_cast<std::size_t>(r) * patches.cols + c];
        EXPECT_EQ(patches.patchAt(r, c), static_cast<int>(k)) << r << ", " << c;
      }
    }
  }
  for (const int times : covered) EXPECT_EQ(times, 1);
}

TEST(PatchGrid, KeepsIncompletePatchesAtTheEdges) {
  const PatchGrid patches = makePatchGrid(frontalWall(10, 11), 4, false);
  EXPECT_EQ(patches.strips(), 3);
  ASSERT_EQ(patches.patches.size(), 9U);
  EXPECT_EQ(patches.patches[0].moments.n, 16);
  const Patch& corner = patches.patches[8];
  EXPECT_EQ(corner.row_begin, 8);
  EXPECT_EQ(corner.row_end, 10);
  EXPECT_EQ(corner.col_begin, 8);
  EXPECT_EQ(corner.col_end, 11);
  EXPECT_EQ(corner.moments.n, 6);
  expectPartition(patches);
}

TEST(PatchGrid, CoversImagesOfAnyShape) {
  for (const auto& [rows, cols] : std::vector<std::pair<int, int>>{{1, 37}, {37, 1}, {1, 1}, {3, 5}, {2, 2}, {33, 29}}) {
    for (const int k : {2, 4, 7, 64}) {
      for (const bool equal_angle : {false, true}) {
        const PatchGrid patches = makePatchGrid(frontalWall(rows, cols), k, equal_angle);
        expectPartition(patches);
        int points = 0;
        for (const Patch& patch : patches.patches) points += patch.moments.n;
        EXPECT_EQ(points, rows * cols);
      }
    }
  }
}

TEST(PatchGrid, SumsTheValidPointsWithUnitNoise) {
  BeamGrid grid = frontalWall(8, 8, 0.02);
  grid.range[grid.index(1, 2)] = kNoRange;
  LabelImage done{8, 8, std::vector<std::int32_t>(64, 0)};
  done.labels[grid.index(0, 0)] = 3;
  const PatchGrid patches = makePatchGrid(grid, 4, false, &done);
  double xz = 0.0, w = 0.0, ranges = 0.0;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      if ((r == 1 && c == 2) || (r == 0 && c == 0)) continue;
      const Eigen::Vector3d p = grid.point(grid.index(r, c)).cast<double>();
      xz += p.squaredNorm() * p.x() * p.z();
      w += p.squaredNorm();
      ranges += p.norm();
    }
  }
  const Patch& patch = patches.patches[0];
  EXPECT_EQ(patch.moments.n, 14);
  EXPECT_NEAR(patch.moments.xz, xz, 1e-5 * std::abs(xz));
  EXPECT_NEAR(patch.moments.w, w, 1e-5 * w);
  EXPECT_NEAR(patch.range, ranges / 14.0, 1e-6);
  EXPECT_FALSE(patch.planar);
}

// Four patches are fitted at a time, four columns summed: none may get the numbers of another.
TEST(PatchGrid, EveryPatchHasItsOwnSums) {
  for (const bool with_origins : {false, true}) {
    for (const int k : {3, 4, 7}) {
      BeamGrid grid = frontalWall(13, 27, 0.02);
      for (int i = 0; i < grid.size(); ++i) grid.range[i] += 0.01F * static_cast<float>(i % 7);
      for (int i = 5; i < 60; ++i) grid.range[i] = kNoRange;
      if (with_origins) {
        for (auto* numbers : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) numbers->resize(grid.range.size());
        for (int i = 0; i < grid.size(); ++i) grid.origin_x[i] = 0.001F * static_cast<float>(i % 5);
      }
      const PatchGrid patches = makePatchGrid(grid, k, false);
      for (const Patch& patch : patches.patches) {
        Moments sums;
        double ranges = 0.0;
        for (int r = patch.row_begin; r < patch.row_end; ++r) {
          for (int i = grid.index(r, patch.col_begin); i < grid.index(r, patch.col_end); ++i) {
            if (!grid.valid(i)) continue;
            const Eigen::Vector3d p = grid.point(i).cast<double>() - patches.center;
            sums.add(p.x(), p.y(), p.z(), static_cast<double>(grid.range[i]) * grid.range[i]);
            ranges += grid.range[i];
          }
        }
        ASSERT_EQ(patch.moments.n, sums.n);
        if (sums.n == 0) continue;
        EXPECT_NEAR(patch.moments.w, sums.w, 1e-5 * sums.w);
        EXPECT_NEAR(patch.moments.x, sums.x, 1e-5 * std::abs(sums.x));
        EXPECT_NEAR(patch.moments.yz, sums.yz, 1e-5 * (sums.yy + sums.zz));
        EXPECT_NEAR(patch.range, ranges / sums.n, 1e-5);
        EXPECT_NEAR(patch.fit.chi2, fitPlane(patch.moments).chi2, 1e-12 * sums.w);
      }
    }
  }
}

TEST(PatchGrid, MomentsAreAboutTheMeanSensorPosition) {
  BeamGrid grid = toBeamGrid(noddingScan(21, 21, -0.2, 0.2, 0.2, {0.0, 0.0, 0.1}));
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  const PatchGrid patches = makePatchGrid(grid, 21, false);
  EXPECT_NEAR(patches.center.x(), 0.0, 1e-6);
  EXPECT_NEAR(patches.center.z(), 0.1 * std::sin(0.21) / (21.0 * std::sin(0.01)), 1e-6);  // mean of 0.1 cos over the tilts
  EXPECT_NEAR(patches.patches[0].moments.mean().x(), 2.0, 1e-5);
}

TEST(PatchGrid, NeighboursShareAnEdge) {
  // Towards the poles at +-90 deg of bearing patches grow higher, so that one patch meets several of the next strip.
  BeamGrid grid = toBeamGrid(noddingScan(60, 61, -0.5, 0.5, 80.0 * kDegree));
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  const PatchGrid patches = makePatchGrid(grid, 4, true);
  std::vector<std::set<int>> expected(patches.patches.size());
  const auto meet = [&](int a, int b) {
    if (a == b) return;
    expected[a].insert(b);
    expected[b].insert(a);
  };
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      if (r + 1 < grid.rows) meet(patches.patchAt(r, c), patches.patchAt(r + 1, c));
      if (c + 1 < grid.cols) meet(patches.patchAt(r, c), patches.patchAt(r, c + 1));
    }
  }
  std::size_t most = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    std::vector<int> found;
    patches.forEachNeighbour(static_cast<int>(k), [&](int j) { found.push_back(j); });
    EXPECT_EQ(std::set<int>(found.begin(), found.end()), expected[k]) << k;
    EXPECT_EQ(found.size(), expected[k].size()) << k;
    most = std::max(most, found.size());
  }
  EXPECT_GT(most, 4U);
}

TEST(PatchGrid, PatchesAreAsHighAsWideInAngle) {
  BeamGrid grid = toBeamGrid(noddingScan(300, 101, -0.3, 0.3, 0.5));  // steps of 2 and 10 mrad
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  const PatchGrid patches = makePatchGrid(grid, 4, true);
  const double ratio = 0.01 / (0.6 / 299.0);
  EXPECT_NEAR(patches.strip_rows[12], 1.3 * ratio * 4.0, 1.0);
  EXPECT_EQ(makePatchGrid(grid, 4, false).strip_rows[12], 4);
}

// A motor that goes in steps, with some lines at each.
TEST(PatchGrid, PatchesReachOverSeveralSteps) {
  for (const int lines : {2, 3, 5}) {
    RangeImage image = noddingScan(300, 101, -0.3, 0.3, 0.5);
    for (int r = 0; r < image.rows; ++r) image.line_poses[r] = image.line_poses[r / lines * lines];
    BeamGrid grid = toBeamGrid(image);
    scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
    EXPECT_NEAR(makePatchGrid(grid, 4, true).strip_rows[12], 1.3 * 0.01 / (0.6 / 299.0) * 4.0, 6.0) << lines;
  }
}

TEST(PatchGrid, PatchesGrowTowardsThePole) {
  BeamGrid grid = toBeamGrid(noddingScan(400, 271, -0.8, 0.8, 135.0 * kDegree));
  scan({wall({-1.0, 0.0, 0.0}, -2.0), wall({1.0, 0.0, 0.0}, -2.0)}, grid);
  const PatchGrid patches = makePatchGrid(grid, 4, true);
  const int ahead = patches.strip_rows[135 / 4], oblique = patches.strip_rows[(135 + 60) / 4];
  EXPECT_NEAR(oblique, ahead / std::cos(60.0 * kDegree), 0.1 * oblique);
  EXPECT_EQ(patches.strip_rows[(135 + 90) / 4], 16 * 4);  // limited
}

TEST(PatchGrid, AnImageWithoutPointsHasEmptyPatches) {
  const PatchGrid patches = makePatchGrid(forwardBeams(9, 9, 0.01), 4, true);
  expectPartition(patches);
  for (const Patch& patch : patches.patches) {
    EXPECT_EQ(patch.moments.n, 0);
    EXPECT_EQ(patch.range, 0.0);
  }
}

}  // namespace
}  // namespace ppc
