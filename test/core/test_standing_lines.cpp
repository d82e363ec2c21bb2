// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/standing_lines.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kCols = 400;
constexpr double kTiltStep = 0.4 * kDegree, kLeverArm = 0.1;  // [m]

// A wall ahead and a floor, seen by a laser that nods through these tilts.
struct Room {
  BeamGrid grid;
  LabelImage truth;

  explicit Room(const std::vector<double>& tilts) {
    RangeImage image = noddingScan(static_cast<int>(tilts.size()), kCols, 0.0, 1.0, 0.9);
    for (std::size_t k = 0; k < tilts.size(); ++k) {
      Eigen::Isometry3d pose(Eigen::AngleAxisd(tilts[k], Eigen::Vector3d::UnitY()));
      pose.translation() = pose.linear() * Eigen::Vector3d(0.0, 0.0, kLeverArm);
      image.line_poses[k] = pose;
      image.tilts[k] = tilts[k];
    }
    grid = toBeamGrid(image);
    truth = scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -1.0)}, grid);
    addNoise(grid, 0.01);
  }
};

// `repeats` lines at each of 100 tilts.
std::vector<double> steps(int repeats) {
  std::vector<double> tilts;
  for (int k = 0; k < 100; ++k) tilts.insert(tilts.end(), repeats, (k - 50) * kTiltStep);
  return tilts;
}

// 30 lines at the first of 100 tilts, 40 amid them.
std::vector<double> waits() {
  std::vector<double> tilts = steps(1);
  tilts.insert(tilts.begin() + 25, 39, tilts[25]);
  tilts.insert(tilts.begin(), 29, tilts[0]);
  return tilts;
}

BeamGrid transposed(const BeamGrid& grid) {
  BeamGrid out = grid;
  out.rows = grid.cols;
  out.cols = grid.rows;
  for (const auto numbers : {&BeamGrid::range, &BeamGrid::dir_x, &BeamGrid::dir_y, &BeamGrid::dir_z, &BeamGrid::origin_x,
                             &BeamGrid::origin_y, &BeamGrid::origin_z}) {
    if ((grid.*numbers).empty()) continue;
    for (int i = 0; i < grid.size(); ++i) (out.*numbers)[out.index(i % grid.cols, i / grid.cols)] = (grid.*numbers)[i];
  }
  return out;
}

TEST(StandingLines, AreNoneWhereEachLineMoves) {
  StandingLineMemory memory;
  EXPECT_FALSE(thinStandingLines(Room(steps(1)).grid, memory));
  EXPECT_FALSE(thinStandingLines(transposed(Room(steps(1)).grid), memory));
  EXPECT_FALSE(thinStandingLines(Room(steps(4)).grid, memory));  // patches reach over several steps
  std::vector<double> turning = steps(1);                        // a few do no harm
  turning.insert(turning.begin(), 6, turning[0]);
  EXPECT_FALSE(thinStandingLines(Room(turning).grid, memory));
  std::vector<double> gap = steps(1);  // lines that move by less than others do not stand
  for (std::size_t k = 50; k < gap.size(); ++k) gap[k] += 20.0 * kDegree;
  EXPECT_FALSE(thinStandingLines(Room(gap).grid, memory));
}

TEST(StandingLines, AreNoneWhereNothingMovesOrNothingIsMeasured) {
  StandingLineMemory memory;
  EXPECT_FALSE(thinStandingLines(Room(std::vector<double>(100, 0.1)).grid, memory));
  BeamGrid empty = forwardBeams(50, 60, 0.01);
  EXPECT_FALSE(thinStandingLines(empty, memory));
  EXPECT_FALSE(thinStandingLines(BeamGrid(), memory));
}

TEST(StandingLines, AreLeftOutWhereTheMotorWaits) {
  const Room room(waits());
  StandingLineMemory memory;
  ASSERT_TRUE(thinStandingLines(room.grid, memory));
  EXPECT_EQ(memory.grid.rows, 100);
  EXPECT_EQ(memory.grid.cols, kCols);
  EXPECT_EQ(memory.kept[0], 0);
  EXPECT_EQ(memory.kept[1], 30);
  EXPECT_EQ(memory.stands_for[29], 0);
  for (int line = 0; line < 100; ++line) {
    for (int c = 0; c < kCols; ++c) {
      const int i = memory.grid.index(line, c), of = room.grid.index(memory.kept[line], c);
      ASSERT_EQ(memory.grid.range[i], room.grid.range[of]);
      ASSERT_EQ(memory.grid.direction(i), room.grid.direction(of));
      ASSERT_EQ(memory.grid.origin(i), room.grid.origin(of));
    }
  }
}

TEST(StandingLines, AreFoundInColumnsToo) {
  const Room room(waits());
  StandingLineMemory in_rows, in_columns;
  ASSERT_TRUE(thinStandingLines(room.grid, in_rows));
  ASSERT_TRUE(thinStandingLines(transposed(room.grid), in_columns));
  EXPECT_EQ(in_rows.grid.rows, 100);
  EXPECT_EQ(in_columns.kept, in_rows.kept);
  EXPECT_EQ(in_columns.grid.range, transposed(in_rows.grid).range);
}

TEST(StandingLines, HaveTheLabelsOfTheLineThatStandsForThem) {
  Room room(waits());
  const int strange = room.grid.index(20, 50), missing = room.grid.index(20, 60), other = room.grid.index(20, 70);
  room.grid.range[strange] = 0.7F;
  room.grid.range[missing] = kNoRange;
  StandingLineMemory memory;
  ASSERT_TRUE(thinStandingLines(room.grid, memory));
  memory.labels = LabelImage{100, kCols, std::vector<std::int32_t>(100 * kCols)};
  for (int i = 0; i < 100 * kCols; ++i) memory.labels.labels[i] = 1 + i % 3;
  LabelImage labels;
  labelStandingLines(room.grid, memory, labels);
  ASSERT_EQ(labels.rows, 168);
  ASSERT_EQ(labels.cols, kCols);
  EXPECT_EQ(labels.labels[strange], 0);
  EXPECT_EQ(labels.labels[missing], 0);
  EXPECT_EQ(labels.labels[other], memory.labels.labels[memory.grid.index(0, 70)]);
  const auto without = std::count(labels.labels.begin(), labels.labels.end(), 0);
  EXPECT_LT(without,
            40);  // of 47 lines that are left out, one point of 200 000 is so far off by noise; and where walls meet
  for (int c = 0; c < kCols; ++c) EXPECT_EQ(labels.labels[room.grid.index(30, c)], memory.labels.labels[kCols + c]);
}

// However the ranges of two lines that stand differ: coarse steps of them, more noise of one surface than of another.
TEST(StandingLines, KeepLabelsOnRangesInStepsAndOnNoisySurfaces) {
  for (const double step : {0.0, 0.01}) {
    Room room(waits());
    Normal normal(7);
    for (int i = 0; i < room.grid.size(); ++i) {
      const bool dark = i % kCols > kCols / 2;
      const double exact = room.grid.range[i], noise = step > 0.0 ? 0.001 : dark ? 0.03 : 0.0;
      room.grid.range[i] = static_cast<float>(exact + noise * normal());
      if (step > 0.0) room.grid.range[i] = static_cast<float>(step * std::round((3.0 + 0.002 * normal()) / step));
    }
    StandingLineMemory memory;
    ASSERT_TRUE(thinStandingLines(room.grid, memory));
    memory.labels = LabelImage{100, kCols, std::vector<std::int32_t>(100 * kCols)};
    for (int i = 0; i < 100 * kCols; ++i) memory.labels.labels[i] = i % kCols > kCols / 2 ? 2 : 1;
    LabelImage labels;
    labelStandingLines(room.grid, memory, labels);
    for (const bool dark : {false, true}) {
      int without = 0, all = 0;
      for (int i = 0; i < room.grid.size(); ++i) {
        if ((i % kCols > kCols / 2) != dark) continue;
        ++all;
        without += labels.labels[i] == 0 ? 1 : 0;
      }
      EXPECT_LT(without, 0.002 * all) << step << dark;
    }
  }
}

// As a file has it: points about a viewpoint at which the beams do not start.
BeamGrid cloudOf(const BeamGrid& grid) {
  std::vector<float> x, y, z;
  for (int i = 0; i < grid.size(); ++i) {
    const Eigen::Vector3f p = grid.point(i);
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
  return beamGridFromPoints(grid.rows, grid.cols, x, y, z);
}

TEST(StandingLines, DoNotCutSurfaces) {
  const Room room(waits());
  for (const bool in_columns : {false, true}) {
    const BeamGrid cloud = cloudOf(in_columns ? transposed(room.grid) : room.grid);
    const Segmentation found = segment(cloud, Config());
    ASSERT_EQ(found.regions.size(), 2U);
    EXPECT_GT(found.regions[0].points + found.regions[1].points, 0.98 * cloud.size());
    Config config;
    config.thin_standing_lines = false;
    EXPECT_GT(segment(cloud, config).regions.size(), 2U) << "nothing to mend";
  }
}

}  // namespace
}  // namespace ppc
