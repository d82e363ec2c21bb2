// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/labels_around.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <random>
#include <set>

namespace ppc {
namespace {

using namespace testing_tools;

// What LabelsAround says, written plainly.
std::vector<std::int32_t> plainLabels(const PatchGrid& cells, const CellShares& shares, int cell) {
  std::set<int> reached = {cell};
  for (int step = 0; step < 2; ++step) {
    for (const int from : std::set<int>(reached)) cells.forEachNeighbour(from, [&](int near) { reached.insert(near); });
  }
  std::set<std::int32_t> labels;
  for (const int k : reached) {
    labels.insert(shares.labels.begin() + shares.begin[k], shares.labels.begin() + shares.begin[k + 1]);
  }
  return {labels.begin(), labels.end()};
}

// Up to four labels a cell, none where there are no points.
CellShares randomShares(const PatchGrid& cells, int most, std::mt19937& random) {
  CellShares shares;
  for (const Patch& cell : cells.patches) {
    std::set<std::int32_t> labels;
    const int count = cell.moments.n > 0 ? std::uniform_int_distribution<int>(0, most)(random) : 0;
    for (int k = 0; k < count; ++k) labels.insert(std::uniform_int_distribution<int>(1, 9)(random));
    shares.begin.push_back(static_cast<int>(shares.labels.size()));
    shares.only.push_back(labels.empty() ? 0 : labels.size() == 1 ? *labels.begin() : -1);
    shares.labels.insert(shares.labels.end(), labels.begin(), labels.end());
  }
  shares.begin.push_back(static_cast<int>(shares.labels.size()));
  return shares;
}

// Finds labels in images of several sizes, in strips of the same or of various heights, with and without holes.
void expectPlainLabels(bool level, double hole_share, int most) {
  std::mt19937 random(7);
  BlockLabels blocks;
  AroundMemory around_memory;
  int steps = 0;
  for (const auto& [rows, cols] :
       {std::pair(120, 96), std::pair(97, 61), std::pair(3, 40), std::pair(50, 3), std::pair(2, 2)}) {
    BeamGrid grid = forwardBeams(rows, cols, 0.01);
    scan({wall({-1.0, 0.0, 0.0}, -2.0)}, grid);
    for (int i = 0; i < grid.size(); ++i) {
      const bool hole = (i / cols / 5 + i % cols / 6) % 3 == 0 && hole_share > 0.0;
      if (hole && std::uniform_real_distribution<>(0.0, 1.0)(random) < hole_share) grid.range[i] = kNoRange;
    }
    AngularSteps angles;
    angles.column = level ? 0.0 : 0.01;
    for (int c = 0; !level && c < cols + 8; c += 8) angles.rows.push_back(0.01 / (1 + c / 8 % 4));
    PatchGridMemory memory;
    PatchGrid cells;
    makePatchGrid(grid, 4, angles, nullptr, 1, memory, cells);
    const CellShares shares = randomShares(cells, most, random);
    blocks.list(cells, shares);
    LabelsAround around(cells, shares, blocks, around_memory);
    for (int k = 0; k < static_cast<int>(cells.patches.size()); ++k) {
      if (cells.patches[k].moments.n == 0) continue;
      EXPECT_EQ(around.find(k), plainLabels(cells, shares, k)) << k << " of " << rows << " x " << cols;
      ++steps;
    }
  }
  EXPECT_GT(steps, 100);
}

TEST(LabelsAround, AreFoundAmongLikeStrips) { expectPlainLabels(true, 0.0, 1); }
TEST(LabelsAround, AreFoundAmongStripsOfVariousHeights) { expectPlainLabels(false, 0.0, 1); }
TEST(LabelsAround, AreFoundInCellsOfSeveralLabels) {
  for (const int most : {2, 4}) {
    expectPlainLabels(true, 0.0, most);
    expectPlainLabels(false, 0.0, most);
  }
}
TEST(LabelsAround, AreNotFoundAcrossCellsWithoutPoints) {
  for (const double share : {0.8, 1.0}) {
    expectPlainLabels(true, share, 3);
    expectPlainLabels(false, share, 3);
  }
}

}  // namespace
}  // namespace ppc
