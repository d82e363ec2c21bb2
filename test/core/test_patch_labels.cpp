// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_labels.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

TEST(PatchLabels, PaintTheValidPixelsOfClusteredPatches) {
  BeamGrid grid = forwardBeams(8, 8, 0.01);
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  grid.range[grid.index(0, 1)] = kNoRange;
  const PatchGrid patches = makePatchGrid(grid, 4, false);
  LabelImage labels;
  CellShares shares;
  PatchClusters clusters;
  clusters.cluster_of = {0, -1, 1, 0};  // strip by strip
  shareClusters(clusters, shares);
  std::vector<PatchRow> memory;
  patchLabels(grid, patches, shares, memory, labels);
  EXPECT_EQ(labels.labels[grid.index(0, 0)], 1);
  EXPECT_EQ(labels.labels[grid.index(0, 1)], 0);
  EXPECT_EQ(labels.labels[grid.index(7, 0)], 0);
  EXPECT_EQ(labels.labels[grid.index(0, 7)], 2);
  EXPECT_EQ(labels.labels[grid.index(7, 7)], 1);
  EXPECT_EQ(countOf(labels, 1), 31);
}

// Strips of various heights and widths, some patches without a label, painted by several threads.
TEST(PatchLabels, AreThoseOfEveryPixelsPatch) {
  BeamGrid grid = forwardBeams(53, 75, 0.01);
  scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
  for (int i = 0; i < grid.size(); i += 9) grid.range[i] = kNoRange;
  AngularSteps steps;
  steps.column = 0.01;
  for (int c = 0; c < grid.cols + 8; c += 8) steps.rows.push_back(0.01 / (1 + c / 8 % 4));
  PatchGridMemory grid_memory;
  std::vector<PatchRow> memory;
  for (const int size : {3, 4, 6, 8}) {
    PatchGrid patches;
    makePatchGrid(grid, size, steps, nullptr, 1, grid_memory, patches);
    PatchClusters clusters;
    std::vector<int>& cluster_of = clusters.cluster_of;
    for (int p = 0; p < static_cast<int>(patches.patches.size()); ++p) cluster_of.push_back(p % 5 == 2 ? -1 : p * 7 % 11);
    CellShares shares;
    shareClusters(clusters, shares);
    for (const int threads : {1, 3}) {
      LabelImage labels;
      patchLabels(grid, patches, shares, memory, labels, threads);
      for (int r = 0; r < grid.rows; ++r) {
        for (int c = 0; c < grid.cols; ++c) {
          const int i = grid.index(r, c);
          EXPECT_EQ(labels.labels[i], grid.valid(i) ? cluster_of[patches.patchAt(r, c)] + 1 : 0) << r << ", " << c;
        }
      }
    }
  }
}

}  // namespace
}  // namespace ppc
