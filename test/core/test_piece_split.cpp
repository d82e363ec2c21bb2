// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/piece_split.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

// Every pixel by the handedness around its four corners, one by one.
std::vector<std::int32_t> splitPlainly(const CornerProjection& projection, const PieceMask& mask) {
  std::vector<std::int32_t> split;
  for (int r = 0; r < mask.labels.rows; ++r) {
    for (int c = 0; c < mask.labels.cols; ++c) {
      int sum = 0;
      for (const int row : {r, r + 1}) {
        for (const int col : {c, c + 1}) sum += projection.handedness(mask.row + row, mask.col + col);
      }
      const std::int32_t label = sum == 4 ? 1 : (sum == -4 ? 2 : 0);
      split.push_back(mask.labels.labels[static_cast<std::size_t>(r * mask.labels.cols + c)] * label);
    }
  }
  return split;
}

TEST(PieceSplit, FoldsAreFoundAsPixelByPixel) {
  std::mt19937 random(7);
  for (const double lever : {0.0, 0.06}) {
    RangeImage image = noddingScan(61, 141, -30 * kDegree, 30 * kDegree, 70 * kDegree, {lever, 0.0, lever});
    image.bearing_min -= 60 * kDegree;  // from 130 degrees on the right to 10 on the left: the pole is at 90
    const BeamGrid grid = toBeamGrid(image);
    const LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 1)};
    PlanarRegion region;
    region.id = 1;
    region.plane = {Eigen::Vector3d::UnitY(), -2.0};
    region.centroid = {0.0, -2.0, 0.0};
    const CornerProjection projection(grid, labels, region);
    PieceMask mask;
    mask.row = 3;
    mask.col = 5;
    mask.labels = {45, 77, {}};  // neither is a multiple of the size of the blocks
    for (int i = 0; i < 45 * 77; ++i) {
      const bool hole = (i / 77 - 20) * (i / 77 - 20) + (i % 77 - 60) * (i % 77 - 60) < 150;
      mask.labels.labels.push_back(hole || random() % 8 == 0 ? 0 : 1);
    }
    const std::vector<std::int32_t> expected = splitPlainly(projection, mask);
    FoldMemory memory;
    ASSERT_TRUE(splitAtFolds(projection, mask, memory));
    EXPECT_EQ(mask.labels.labels, expected);
  }
}

TEST(PieceSplit, PieceWithoutFoldStays) {
  const BeamGrid grid = forwardBeams(20, 30, 0.02);
  const LabelImage labels{20, 30, std::vector<std::int32_t>(600, 1)};
  PlanarRegion region;
  region.id = 1;
  region.plane = {-Eigen::Vector3d::UnitX(), -3.0};
  region.centroid = {3.0, 0.0, 0.0};
  PieceMask mask{0, 0, labels};
  FoldMemory memory;
  EXPECT_FALSE(splitAtFolds(CornerProjection(grid, labels, region), mask, memory));
  EXPECT_EQ(mask.labels.labels, labels.labels);
}

}  // namespace
}  // namespace ppc
