// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/range_limit.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kLimit = 4.0, kSigma = 0.04;  // [m]
const NoiseModel kNoise(SensorModel{kSigma, kSigma, 10.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance;

// A wall ahead, which goes on beyond the sensor's range on both sides, and a floor.
BeamGrid hall(double limit) {
  BeamGrid grid = forwardBeams(200, 300, 0.006);
  scan({wall({-1.0, 0.0, 0.0}, -3.5), wall({0.0, 0.0, 1.0}, -0.8)}, grid);
  addNoise(grid, kSigma);
  for (float& range : grid.range) range = range > limit ? kNoRange : range;
  return grid;
}

PatchGrid patchesOf(const BeamGrid& grid) {
  PatchGrid patches = makePatchGrid(grid, 8, true);
  weighAndGatePatches(kNoise, kTolerance, patches);
  return patches;
}

// Leaves out a share of the measurements, wherever they are.
void dropAtRandom(double share, BeamGrid& grid) {
  std::mt19937 random(7);
  for (float& range : grid.range) {
    if (std::generate_canonical<double, 32>(random) < share) range = kNoRange;
  }
}

TEST(RangeLimit, IsFoundWhereAWallGoesOnBeyondIt) {
  const std::optional<double> limit = findRangeLimit(patchesOf(hall(kLimit)), kNoise);
  ASSERT_TRUE(limit);
  EXPECT_LT(*limit, kLimit);
  EXPECT_GT(*limit, kLimit - 2.0 * kSigma);
}

TEST(RangeLimit, IsNotFoundWhereAllIsMeasured) {
  BeamGrid closed = forwardBeams(200, 300, 0.006);
  scan({wall({0.0, -1.0, 0.0}, -1.4), wall({0.0, 1.0, 0.0}, -1.4), wall({-1.0, 0.0, 0.0}, -3.5)}, closed);
  addNoise(closed, kSigma);
  EXPECT_FALSE(findRangeLimit(patchesOf(closed), kNoise));
  dropAtRandom(0.05, closed);
  EXPECT_FALSE(findRangeLimit(patchesOf(closed), kNoise));
  EXPECT_FALSE(findRangeLimit(PatchGrid(), kNoise));
}

TEST(RangeLimit, MarksPatchesWithHolesBeforeIt) {
  const BeamGrid grid = hall(kLimit);
  PatchGrid patches = patchesOf(grid);
  const PatchGrid before = patches;
  markTruncated(grid, std::nullopt, kNoise, patches);
  EXPECT_TRUE(patches.truncated.empty());
  const double limit = findRangeLimit(patches, kNoise).value();
  markTruncated(grid, limit, kNoise, patches);
  ASSERT_EQ(patches.truncated.size(), patches.patches.size());
  int marked = 0, planar = 0;
  for (std::size_t k = 0; k < patches.patches.size(); ++k) {
    const Patch& patch = patches.patches[k];
    const bool has_holes = patch.moments.n > 0 && patch.moments.n <= 0.95 * patch.pixels();
    EXPECT_EQ(patches.truncated[k] != 0, has_holes && patch.range >= limit - 6.0 * kSigma);
    EXPECT_EQ(patch.planar, before.patches[k].planar && patches.truncated[k] == 0);
    marked += patches.truncated[k];
    planar += patch.planar ? 1 : 0;
  }
  EXPECT_GT(marked, 10);
  EXPECT_GT(planar, 200);
}

TEST(RangeLimit, OfAnImageBeforeIsForgotten) {
  const BeamGrid grid = hall(kLimit);
  PatchGridMemory memory;
  AngularSteps steps;
  PatchGrid patches;
  for (int k = 0; k < 2; ++k) {
    makePatchGrid(grid, 8, steps, nullptr, 1, memory, patches);
    EXPECT_TRUE(patches.truncated.empty());
    markTruncated(grid, kLimit, kNoise, patches);
    EXPECT_FALSE(patches.truncated.empty());
  }
}

TEST(RangeLimit, LeavesNoStripsAlongIt) {
  Config config;
  config.sensor = SensorModel{kSigma, kSigma, 10.0, 0.0};
  EXPECT_EQ(segment(hall(kLimit), config).regions.size(), 2U);
  config.avoid_range_limit = false;
  EXPECT_GT(segment(hall(kLimit), config).regions.size(), 2U);
}

}  // namespace
}  // namespace ppc
