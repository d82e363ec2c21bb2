// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/strays.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 240, kCols = 541;
constexpr double kSigma = 0.01;  // [m]

struct Scene {
  BeamGrid grid;
  std::vector<char> is_stray;  // clearly; those in between are either
  std::vector<char> is_true;

  explicit Scene(const BeamGrid& beams) : grid(beams), is_stray(beams.range.size(), 0), is_true(beams.range.size(), 1) {}

  void addStrays(double share) {
    Normal normal(7);
    for (int i = 0; i < grid.size(); ++i) {
      if (!grid.valid(i) || normal.uniform() > share) continue;
      const auto range = static_cast<float>(0.2 + 7.0 * normal.uniform());
      is_stray[i] = std::abs(range - grid.range[i]) > 0.3F ? 1 : 0;
      is_true[i] = 0;
      grid.range[i] = range;
    }
  }
};

BeamGrid seenUpTo(float farthest, BeamGrid grid) {
  for (float& range : grid.range) range = range < farthest ? range : kNoRange;
  return grid;
}

// A floor, a wall ahead and one to the left, which a nodding laser sees out to its pole.
struct Room : Scene {
  explicit Room(double sigma = kSigma) : Scene(walls()) { addNoise(grid, sigma); }

 private:
  static BeamGrid walls() {
    BeamGrid grid = toBeamGrid(noddingScan(kRows, kCols, -0.9, 0.9, 2.3));
    scan({wall({0.0, 0.0, 1.0}, -1.0), wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, -1.0, 0.0}, -2.0)}, grid);
    return seenUpTo(20.0F, grid);
  }
};

TEST(ClearStrays, ClearsThemAndNothingElse) {
  for (const double share : {0.03, 0.1}) {
    Room room;
    room.addStrays(share);
    StrayMemory memory;
    ASSERT_TRUE(clearStrays(room.grid, memory)) << share;
    int strays = 0, left = 0, lost = 0;
    for (int i = 0; i < room.grid.size(); ++i) {
      if (!room.grid.valid(i)) continue;
      strays += room.is_stray[i];
      left += memory.grid.valid(i) ? room.is_stray[i] : 0;
      lost += memory.grid.valid(i) ? 0 : room.is_true[i];
    }
    EXPECT_GT(strays, 0.6 * share * room.grid.size()) << share;
    EXPECT_LT(left, 0.04 * strays) << share;
    EXPECT_LT(lost, 0.002 * room.grid.size()) << share;
  }
}

TEST(ClearStrays, LeavesImagesAloneThatHaveFew) {
  StrayMemory memory;
  for (const double sigma : {0.0, 0.001, 0.01, 0.04}) EXPECT_FALSE(clearStrays(Room(sigma).grid, memory)) << sigma;
  Room room;
  room.addStrays(0.01);
  EXPECT_FALSE(clearStrays(room.grid, memory));
  BeamGrid empty = room.grid;
  empty.range.assign(empty.range.size(), kNoRange);
  EXPECT_FALSE(clearStrays(empty, memory));
  for (const int rows : {1, 2, 4}) {  // too few to tell
    BeamGrid few = forwardBeams(rows, 90, 0.01);
    for (int i = 0; i < few.size(); ++i) few.range[i] = i % 3 == 0 ? 1.0F : 4.0F;
    EXPECT_FALSE(clearStrays(few, memory));
  }
}

// Of a floor seen at a grazing angle, all that has been measured beside its far border is nearer.
TEST(ClearStrays, KeepsTheBordersOfWhatWasMeasured) {
  BeamGrid grid = toBeamGrid(noddingScan(32, kCols, -0.2, 0.5, 2.3));
  scan({wall({0.0, 0.0, 1.0}, -1.0)}, grid);
  Scene floor(seenUpTo(30.0F, grid));
  floor.addStrays(0.05);
  StrayMemory memory;
  ASSERT_TRUE(clearStrays(floor.grid, memory));
  int lost = 0, cleared = 0;
  for (int i = 0; i < floor.grid.size(); ++i) {
    if (!floor.grid.valid(i) || memory.grid.valid(i)) continue;
    ++cleared;
    lost += floor.is_true[i];
  }
  EXPECT_GT(cleared, 200);
  EXPECT_LT(lost, 0.02 * cleared);
}

// Structured light measures depth in steps that grow with its square; noise decides between two of them.
TEST(ClearStrays, KeepsRangesInSteps) {
  BeamGrid grid = forwardBeams(200, 300, 0.003);
  scan({wall({-1.0, 0.0, 0.0}, -4.0), wall({0.0, 0.0, 1.0}, -0.7)}, grid);
  Normal normal(3);
  constexpr double kStep = 0.01;
  for (int i = 0; i < grid.size(); ++i) {
    const double cosine = grid.dir_x[i], disparity = 1.0 / (grid.range[i] * cosine) + 0.4 * kStep * normal();
    grid.range[i] = static_cast<float>(1.0 / (kStep * std::round(disparity / kStep)) / cosine);
  }
  StrayMemory memory;
  EXPECT_FALSE(clearStrays(grid, memory));
}

// A wire is as thin as a stray, but has a length.
TEST(ClearStrays, KeepsLinesAndEdges) {
  Room room;
  std::vector<char> on_wire(room.is_true.size(), 0);
  for (int r = 20; r < 200; ++r) {
    for (const int i : {room.grid.index(r, 200), room.grid.index(100, r), room.grid.index(r, 100 + r)}) {
      room.grid.range[i] = 1.0F;
      on_wire[i] = 1;
    }
  }
  const BeamGrid wires = room.grid;
  room.addStrays(0.03);
  for (std::size_t i = 0; i < on_wire.size(); ++i) {
    if (on_wire[i] != 0) room.grid.range[i] = wires.range[i];
  }
  StrayMemory memory;
  ASSERT_TRUE(clearStrays(room.grid, memory));
  int kept = 0, points = 0;
  for (std::size_t i = 0; i < on_wire.size(); ++i) {
    points += on_wire[i];
    kept += memory.grid.valid(static_cast<int>(i)) ? on_wire[i] : 0;
  }
  EXPECT_GT(kept, 0.97 * points);  // but for the ends
}

TEST(ClearStrays, DoesNotDependOnThreads) {
  Room room;
  room.addStrays(0.1);
  StrayMemory one, three;
  ASSERT_TRUE(clearStrays(room.grid, one));
  ASSERT_TRUE(clearStrays(room.grid, three, 3));
  for (int i = 0; i < room.grid.size(); ++i) ASSERT_EQ(one.grid.valid(i), three.grid.valid(i)) << i;
}

TEST(Segment, KeepsWallsWholeAmongStrays) {
  Room room;
  Config config;
  const std::size_t kept = segment(room.grid, config).regions.size();
  room.addStrays(0.08);
  const Segmentation found = segment(room.grid, config);
  EXPECT_EQ(found.regions.size(), kept);
  int planar = 0;
  for (const PlanarRegion& region : found.regions) planar += region.points;
  EXPECT_GT(planar, 0.9 * found.valid_points);
  for (int i = 0; i < room.grid.size(); ++i) {
    if (room.is_stray[i] != 0) planar -= found.labels.labels[i] > 0 ? 1000 : 0;
  }
  EXPECT_GT(planar, 0);  // next to none of the strays has a label
  config.clear_strays = false;
  EXPECT_GT(segment(room.grid, config).regions.size(), kept);
}

}  // namespace
}  // namespace ppc
