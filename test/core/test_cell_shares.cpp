// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_shares.h"

#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <map>

namespace ppc {
namespace {

using namespace testing_tools;

const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);

// A wall whose labels change along slanting borders; some pixels have no label, some no range.
struct Scene {
  BeamGrid grid = forwardBeams(60, 82, 0.005);
  LabelImage labels;
  PatchGrid cells;

  Scene() {
    labels = scan({wall({-1.0, 0.2, 0.1}, -3.0)}, grid);
    addNoise(grid, 0.01);
    for (int i = 0; i < grid.size(); ++i) {
      if (i % 97 == 5) grid.range[i] = kNoRange;
      const int row = i / grid.cols, col = i % grid.cols;
      labels.labels[i] = row + 2 * col < 60 ? 1 : row < 2 * col - 50 ? 3 : col % 31 == 0 ? 0 : 2;
    }
    cells = makePatchGrid(grid, 4, true);
    weighPatches(kNoise, cells);
  }

  // Labels around one pixel become another one. @return whether each cell was touched.
  std::vector<char> change() {
    std::vector<char> changed(cells.patches.size(), 0);
    for (int r = 20; r < 33; ++r) {
      for (int c = 30; c < 50; ++c) {
        labels.labels[grid.index(r, c)] = r == 25 ? 0 : 4;
        changed[cells.patchAt(r, c)] = 1;
      }
    }
    return changed;
  }
};

// Points and first moments of what each label has in a cell, written plainly, with unit noise.
std::map<std::int32_t, Moments> plainShares(const Scene& scene, const Patch& cell) {
  std::map<std::int32_t, Moments> shares;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int c = cell.col_begin; c < cell.col_end; ++c) {
      const int i = scene.grid.index(r, c);
      if (scene.labels.labels[i] == 0 || !scene.grid.valid(i)) continue;
      const Eigen::Vector3d p = scene.grid.point(i).cast<double>() - scene.cells.center;
      const double range = scene.grid.range[i];
      shares[scene.labels.labels[i]].add(p.x(), p.y(), p.z(), range * range);
    }
  }
  return shares;
}

// Sums of the labels against those of the shares.
void expectSums(const Scene& scene, const CellShares& shares) {
  std::map<std::int32_t, Moments> plain;
  for (int k = 0; k < static_cast<int>(scene.cells.patches.size()); ++k) {
    for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
      plain[shares.labels[s]] += shares.momentsOf(scene.cells, k, s);
    }
  }
  for (std::int32_t label = 0; label < static_cast<std::int32_t>(shares.sums.size()); ++label) {
    const Moments& sum = shares.sums[label];
    EXPECT_EQ(sum.n, plain[label].n) << label;
    EXPECT_NEAR(sum.xx, plain[label].xx, 1e-9 * plain[label].xx) << label;
    EXPECT_NEAR(sum.w, plain[label].w, 1e-9 * plain[label].w) << label;
    EXPECT_LE((fitPlane(sum).a - fitPlane(plain[label]).a).norm(), 1e-6) << label;
    plain.erase(label);
  }
  EXPECT_TRUE(plain.empty());
}

void expectPlainShares(const Scene& scene, const CellShares& shares) {
  expectSums(scene, shares);
  ASSERT_EQ(shares.begin.size(), scene.cells.patches.size() + 1);
  for (int k = 0; k < static_cast<int>(scene.cells.patches.size()); ++k) {
    const std::map<std::int32_t, Moments> expected = plainShares(scene, scene.cells.patches[k]);
    ASSERT_EQ(shares.begin[k + 1] - shares.begin[k], static_cast<int>(expected.size())) << k;
    EXPECT_EQ(shares.only[k], expected.empty() ? 0 : expected.size() > 1 ? -1 : expected.begin()->first) << k;
    for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
      ASSERT_EQ(expected.count(shares.labels[s]), 1U) << k;
      const Moments& is = shares.momentsOf(scene.cells, k, s);
      const Moments& plain = expected.at(shares.labels[s]);
      EXPECT_EQ(is.n, plain.n) << k;
      // Both are weighed alike but for the one noise of the cell.
      EXPECT_NEAR(is.x / is.w, plain.x / plain.w, 1e-5) << k;
      EXPECT_NEAR(is.w * 1e-4, plain.w, 0.02 * plain.w) << k;
      EXPECT_NEAR(is.xx * 1e-4, plain.xx, 0.02 * plain.xx) << k;
    }
  }
}

void expectSame(const Scene& scene, const CellShares& a, const CellShares& b) {
  EXPECT_EQ(a.begin, b.begin);
  EXPECT_EQ(a.only, b.only);
  ASSERT_EQ(a.labels, b.labels);
  for (int k = 0; k + 1 < static_cast<int>(a.begin.size()); ++k) {
    for (int s = a.begin[k]; s < a.begin[k + 1]; ++s) {
      const Moments& one = a.momentsOf(scene.cells, k, s);
      const Moments& other = b.momentsOf(scene.cells, k, s);
      EXPECT_EQ(one.n, other.n) << k;
      EXPECT_EQ(one.w, other.w) << k;
      EXPECT_EQ(one.yz, other.yz) << k;
    }
  }
}

TEST(ShareCells, SumsWhatEachLabelHasInEveryCell) {
  const Scene scene;
  const CellShares shares = shareCells(scene.grid, scene.cells, kNoise, scene.labels);
  expectPlainShares(scene, shares);
  int whole = 0;
  for (const int part : shares.parts) whole += part == CellShares::kWhole ? 1 : 0;
  EXPECT_GT(whole, 100);
  EXPECT_GT(shares.moments.size(), 50U);
}

TEST(ShareCells, IsTheSameWhateverTheThreads) {
  const Scene scene;
  const CellShares one = shareCells(scene.grid, scene.cells, kNoise, scene.labels);
  for (const int threads : {2, 3}) {
    expectSame(scene, one, shareCells(scene.grid, scene.cells, kNoise, scene.labels, threads));
  }
}

TEST(UpdateShares, GivesWhatSharingAnewGives) {
  for (const int threads : {1, 2, 3}) {
    Scene scene;
    CellShares shares = shareCells(scene.grid, scene.cells, kNoise, scene.labels, threads);
    ShareMemory memory;
    for (int again = 0; again < 2; ++again) {
      const std::vector<char> changed = scene.change();
      updateShares(scene.grid, scene.cells, kNoise, scene.labels, changed, shares, memory, threads);
      expectSame(scene, shares, shareCells(scene.grid, scene.cells, kNoise, scene.labels));
    }
    expectPlainShares(scene, shares);
  }
}

// A label that loses nearly all, and one that loses all.
TEST(UpdateShares, SumsWhatIsLeftOfALabelAnew) {
  Scene scene;
  CellShares shares = shareCells(scene.grid, scene.cells, kNoise, scene.labels);
  ShareMemory memory;
  int left = 5;
  for (std::int32_t& label : scene.labels.labels) label = label == 3 || (label == 1 && --left < 0) ? 2 : label;
  updateShares(scene.grid, scene.cells, kNoise, scene.labels, std::vector<char>(scene.cells.patches.size(), 1), shares,
               memory);
  expectPlainShares(scene, shares);
  ASSERT_EQ(shares.sums.size(), 4U);
  EXPECT_LE(shares.sums[1].n, 5);
  EXPECT_EQ(shares.sums[3].n, 0);
  EXPECT_EQ(shares.sums[3].w, 0.0);
}

TEST(ShareClusters, MakesClustersLabels) {
  PatchClusters clusters;
  clusters.cluster_of = {1, -1, 0, 1};
  clusters.clusters.resize(2);
  clusters.clusters[0].moments.n = 7;
  clusters.clusters[1].moments.n = 9;
  CellShares shares;
  for (int again = 0; again < 2; ++again) {
    shareClusters(clusters, shares);
    EXPECT_EQ(shares.begin, (std::vector<int>{0, 1, 1, 2, 3}));
    EXPECT_EQ(shares.only, (std::vector<std::int32_t>{2, 0, 1, 2}));
    EXPECT_EQ(shares.labels, (std::vector<std::int32_t>{2, 1, 2}));
    EXPECT_EQ(shares.parts, std::vector<int>(3, CellShares::kWhole));
    ASSERT_EQ(shares.sums.size(), 3U);
    EXPECT_EQ(shares.sums[0].n, 0);
    EXPECT_EQ(shares.sums[1].n, 7);
    EXPECT_EQ(shares.sums[2].n, 9);
  }
}

TEST(RenameShares, AddsUpWhatHasBecomeOneInACell) {
  Scene scene;
  CellShares shares = shareCells(scene.grid, scene.cells, kNoise, scene.labels);
  renameShares({0, 1, 2, 1}, shares);
  for (std::int32_t& label : scene.labels.labels) label = label == 3 ? 1 : label;
  expectPlainShares(scene, shares);
}

TEST(LabelPlanes, FitThePointsOfALabel) {
  const Scene scene;
  const auto planes = labelPlanes(shareCells(scene.grid, scene.cells, kNoise, scene.labels));
  ASSERT_EQ(planes.size(), 4U);
  for (std::size_t label = 1; label < 4; ++label) {
    EXPECT_LT((planes[label] - Eigen::Vector3d(-1.0, 0.2, 0.1) / -3.0).norm(), 0.01);
  }
}

}  // namespace
}  // namespace ppc
