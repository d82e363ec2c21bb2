// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);

PatchGrid weighedCells(const BeamGrid& grid) {
  PatchGrid cells = makePatchGrid(grid, 4, true);
  weighPatches(kNoise, cells);
  return cells;
}

LabelImage refine(const BeamGrid& grid, const LabelImage& labels, std::int32_t first_open = 1) {
  const PatchGrid cells = weighedCells(grid);
  const CellShares shares = shareCells(grid, cells, kNoise, labels);
  LabelImage out = labels;
  RefinementMemory memory;
  std::vector<char> changed;
  refineLabels(grid, cells, shares, labelPlanes(shares), kNoise, kTolerance, first_open, memory, out, changed);
  return out;
}

// Two walls that meet at right angles straight ahead, 3 m away; and the labels of whole patches only.
struct Corner {
  BeamGrid grid = forwardBeams(60, 82, 0.005);
  LabelImage truth, coarse;

  Corner() {
    truth = scan({wall({-1.0, 1.0, 0.0}, -3.0 / std::sqrt(2.0)), wall({-1.0, -1.0, 0.0}, -3.0 / std::sqrt(2.0))}, grid);
    addNoise(grid, 0.01);
    coarse = truth;
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 36; c < 44; ++c) coarse.labels[grid.index(r, c)] = 0;
    }
  }
};

TEST(RefineLabels, AssignsTheOpenPixelsAlongACrease) {
  const Corner corner;
  const LabelImage refined = refine(corner.grid, corner.coarse);
  int wrong = 0, open = 0;
  for (int i = 0; i < corner.grid.size(); ++i) {
    open += refined.labels[i] == 0 ? 1 : 0;
    wrong += refined.labels[i] != 0 && refined.labels[i] != corner.truth.labels[i] ? 1 : 0;
  }
  EXPECT_LT(open, 0.01 * corner.grid.size());
  EXPECT_LT(wrong, corner.grid.rows);  // less than a pixel a row
}

TEST(RefineLabels, IsExactWithoutNoise) {
  Corner corner;
  scan({wall({-1.0, 1.0, 0.0}, -3.0 / std::sqrt(2.0)), wall({-1.0, -1.0, 0.0}, -3.0 / std::sqrt(2.0))}, corner.grid);
  const LabelImage refined = refine(corner.grid, corner.coarse);
  for (int r = 0; r < corner.grid.rows; ++r) {
    for (int c = 0; c < corner.grid.cols; ++c) {
      const int i = corner.grid.index(r, c);
      if (std::abs(c - 40.5) > 4.0) {  // there the walls are 3 standard deviations of the noise apart
        EXPECT_EQ(refined.labels[i], corner.truth.labels[i]) << r << ", " << c;
      }
    }
  }
}

TEST(RefineLabels, LeavesOutPointsThatNoPlaneExplains) {
  Corner corner;
  const int inside = corner.grid.index(30, 10), edge = corner.grid.index(30, 38);
  corner.grid.range[inside] += 0.2F;
  corner.grid.range[edge] += 0.2F;
  corner.grid.range[corner.grid.index(20, 10)] = kNoRange;
  LabelImage labels = corner.coarse;
  labels.labels[corner.grid.index(20, 10)] = 0;
  const LabelImage refined = refine(corner.grid, labels);
  EXPECT_EQ(refined.labels[inside], 0);
  EXPECT_EQ(refined.labels[edge], 0);
  EXPECT_EQ(refined.labels[corner.grid.index(20, 10)], 0);
  EXPECT_EQ(refined.labels[corner.grid.index(30, 12)], corner.truth.labels[corner.grid.index(30, 12)]);
}

TEST(RefineLabels, KeepsLabelsBelowTheFirstOpenOne) {
  const Corner corner;
  LabelImage labels = corner.truth;
  const int pixel = corner.grid.index(30, 60);
  const std::int32_t other = 3 - labels.labels[pixel];
  labels.labels[pixel] = other;
  EXPECT_EQ(refine(corner.grid, labels, 3).labels, labels.labels);
  EXPECT_NE(refine(corner.grid, labels, 1).labels[pixel], other);
}

TEST(ContestLabels, MovesABorderToWhereThePlanesMeet) {
  const Corner corner;
  LabelImage labels = corner.truth;
  for (int r = 0; r < corner.grid.rows; ++r) {
    for (int c = 38; c < 46; ++c) labels.labels[corner.grid.index(r, c)] = corner.truth.labels[corner.grid.index(r, 0)];
  }
  const PatchGrid cells = weighedCells(corner.grid);
  const CellShares shares = shareCells(corner.grid, cells, kNoise, labels);
  const std::vector<Eigen::Vector3d> planes = labelPlanes(shareCells(corner.grid, cells, kNoise, corner.truth));
  RefinementMemory memory;
  contestLabels(corner.grid, cells, shares, planes, kNoise, kTolerance, memory, labels);
  int wrong = 0;
  for (int i = 0; i < corner.grid.size(); ++i) wrong += labels.labels[i] != corner.truth.labels[i] ? 1 : 0;
  EXPECT_LT(wrong, corner.grid.rows);  // less than a pixel a row; before, four
}

TEST(ContestLabels, KeepsPointsThatNoPlaneExplains) {
  Corner corner;
  const int edge = corner.grid.index(30, 38);
  corner.grid.range[edge] += 0.5F;
  const PatchGrid cells = weighedCells(corner.grid);
  const CellShares shares = shareCells(corner.grid, cells, kNoise, corner.truth);
  LabelImage labels = corner.truth;
  RefinementMemory memory;
  contestLabels(corner.grid, cells, shares, labelPlanes(shares), kNoise, kTolerance, memory, labels);
  EXPECT_EQ(labels.labels[edge], corner.truth.labels[edge]);
}

}  // namespace
}  // namespace ppc
