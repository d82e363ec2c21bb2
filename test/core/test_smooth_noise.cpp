// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/smooth_noise.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 360, kCols = 480;
constexpr double kStep = 0.15 * kDegree, kTolerance = 0.005;  // [m]

// Sums of neighbours along the rows or columns of an image, weighed by a Gaussian of so many pixels.
std::vector<double> blurred(const std::vector<double>& values, double width, bool along_rows) {
  const int reach = static_cast<int>(4.0 * width);
  std::vector<double> out(values.size(), 0.0);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      for (int k = -reach; k <= reach; ++k) {
        const int row = std::clamp(along_rows ? r : r + k, 0, kRows - 1);
        const int col = std::clamp(along_rows ? c + k : c, 0, kCols - 1);
        out[r * kCols + c] += std::exp(-0.5 * k * k / (width * width)) * values[row * kCols + col];
      }
    }
  }
  return out;
}

// Normal errors of the ranges, alike over a Gaussian of so many pixels.
void addSmoothNoise(BeamGrid& grid, double sigma, double width) {
  Normal normal(3);
  std::vector<double> errors(static_cast<std::size_t>(grid.size()));
  for (double& error : errors) error = normal();
  errors = blurred(blurred(errors, width, true), width, false);
  double squares = 0.0;
  for (const double error : errors) squares += error * error;
  const double scale = sigma / std::sqrt(squares / static_cast<double>(errors.size()));
  for (int i = 0; i < grid.size(); ++i) grid.range[i] += static_cast<float>(scale * errors[i]);
}

// A wall ahead, a floor, a wall to the left and a board before the wall, from so many beams.
struct Corner {
  BeamGrid grid = forwardBeams(kRows, kCols, kStep);
  LabelImage truth;
  int faces;

  Corner() {
    const auto board = [](const Eigen::Vector3d& p) { return std::abs(p.y() + 0.3) < 0.5 && std::abs(p.z() - 0.2) < 0.4; };
    truth = scan({wall({-1.0, 0.0, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.8), wall({0.0, -1.0, 0.0}, -1.2),
                  surfaceOf({{-Eigen::Vector3d::UnitX(), -2.2}, board})},
                 grid);
    faces = renumberBySize(grid, 1000, truth);
  }
};

TEST(SmoothNoise, IsNoneOfIndependentErrors) {
  SmoothNoiseMemory memory;
  Corner exact, fine, coarse;
  EXPECT_FALSE(thinSmoothNoise(exact.grid, kTolerance, memory));
  addNoise(fine.grid, 0.002);
  EXPECT_FALSE(thinSmoothNoise(fine.grid, kTolerance, memory));
  addNoise(coarse.grid, 0.04);
  EXPECT_FALSE(thinSmoothNoise(coarse.grid, kTolerance, memory));
  EXPECT_FALSE(thinSmoothNoise(coarse.grid, 0.0, memory));
}

TEST(SmoothNoise, IsNoneOfErrorsAlongLinesOrBetweenNeighbours) {
  SmoothNoiseMemory memory;
  Corner lines, neighbours;
  addNoise(lines.grid, 0.02, 0.0, 0.8);
  EXPECT_FALSE(thinSmoothNoise(lines.grid, kTolerance, memory));
  addSmoothNoise(neighbours.grid, 0.02, 0.7);
  EXPECT_FALSE(thinSmoothNoise(neighbours.grid, kTolerance, memory));
}

TEST(SmoothNoise, IsNoneWithinTheTolerance) {
  SmoothNoiseMemory memory;
  Corner corner;
  addSmoothNoise(corner.grid, 0.004, 3.0);
  EXPECT_FALSE(thinSmoothNoise(corner.grid, kTolerance, memory));
  EXPECT_TRUE(thinSmoothNoise(corner.grid, 0.0005, memory));
}

TEST(SmoothNoise, IsNoneOfCurvedOrBrokenSurfaces) {
  SmoothNoiseMemory memory;
  BeamGrid curved = forwardBeams(kRows, kCols, kStep), broken = curved;
  std::vector<Surface> waves, boxes;
  for (int k = -4; k <= 4; ++k) waves.push_back(column(3.0, 0.6 * k, 0.5));
  scan(waves, curved);
  EXPECT_FALSE(thinSmoothNoise(curved, 0.0005, memory));
  for (int k = 0; k < 200; ++k) {
    const double y = 0.04 * (k % 60 - 30);
    boxes.push_back(surfaceOf({{-Eigen::Vector3d::UnitX(), -2.0 - 0.3 * (k % 7)},
                               [y](const Eigen::Vector3d& p) { return std::abs(p.y() - y) < 0.02; }}));
  }
  scan(boxes, broken);
  addNoise(broken, 0.001);
  EXPECT_FALSE(thinSmoothNoise(broken, kTolerance, memory));
}

TEST(SmoothNoise, CannotBeToldFromTooFewPoints) {
  SmoothNoiseMemory memory;
  EXPECT_FALSE(thinSmoothNoise(BeamGrid(), kTolerance, memory));
  EXPECT_FALSE(thinSmoothNoise(forwardBeams(kRows, kCols, kStep), kTolerance, memory));
  BeamGrid low = forwardBeams(16, kCols, kStep);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, low);
  EXPECT_FALSE(thinSmoothNoise(low, kTolerance, memory));
}

TEST(SmoothNoise, IsThinnedUntilErrorsAreIndependent) {
  SmoothNoiseMemory memory;
  Corner some, more;
  addSmoothNoise(some.grid, 0.03, 2.5);
  ASSERT_TRUE(thinSmoothNoise(some.grid, kTolerance, memory));
  EXPECT_EQ(memory.rows.size(), static_cast<std::size_t>(memory.grid.rows));
  const int stride = memory.rows[1] - memory.rows[0];
  EXPECT_GE(stride, 2);
  EXPECT_LE(stride, 4);
  EXPECT_EQ(memory.cols[7] - memory.cols[6], stride);
  for (int r = 0; r < memory.grid.rows; ++r) {
    for (int c = 0; c < memory.grid.cols; ++c) {
      const int i = memory.grid.index(r, c), of = some.grid.index(memory.rows[r], memory.cols[c]);
      ASSERT_EQ(memory.grid.range[i], some.grid.range[of]);
      ASSERT_EQ(memory.grid.direction(i), some.grid.direction(of));
    }
  }
  addSmoothNoise(more.grid, 0.03, 5.0);
  ASSERT_TRUE(thinSmoothNoise(more.grid, kTolerance, memory));
  EXPECT_GT(memory.rows[1] - memory.rows[0], stride);
}

TEST(SmoothNoise, LeavesWallsWholeThatWouldFallIntoBumps) {
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  Config config;
  config.thin_smooth_noise = false;
  EXPECT_GT(segment(corner.grid, config).regions.size(), 20U);
  const Segmentation found = segment(corner.grid, Config());
  ASSERT_GE(found.regions.size(), static_cast<std::size_t>(corner.faces));
  for (std::size_t k = corner.faces; k < found.regions.size(); ++k) EXPECT_LT(found.regions[k].points, 2000);
  for (std::int32_t face = 1; face <= corner.faces; ++face) {
    int most = 0;
    for (std::int32_t id = 1; id <= corner.faces; ++id) {
      int both = 0;
      for (int i = 0; i < corner.grid.size(); ++i) {
        both += corner.truth.labels[i] == face && found.labels.labels[i] == id ? 1 : 0;
      }
      most = std::max(most, both);
    }
    EXPECT_GT(most, 0.9 * countOf(corner.truth, face)) << face;
  }
}

TEST(SmoothNoise, LabelsPixelsBetweenThoseOfTheThinnedImage) {
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  SmoothNoiseMemory memory;
  ASSERT_TRUE(thinSmoothNoise(corner.grid, kTolerance, memory));
  memory.labels.rows = memory.grid.rows;
  memory.labels.cols = memory.grid.cols;
  for (const int row : memory.rows) {
    for (const int col : memory.cols) memory.labels.labels.push_back(corner.truth.labels[corner.grid.index(row, col)]);
  }
  const int missing = corner.grid.index(5, 5), strange = corner.grid.index(20, 100);
  corner.grid.range[missing] = kNoRange;
  corner.grid.range[strange] -= 0.5F;
  LabelImage labels;
  labelThinned(corner.grid, Eigen::Vector3d::Zero(), memory, labels);
  EXPECT_EQ(labels.labels[missing], 0);
  EXPECT_EQ(labels.labels[strange], 0);
  EXPECT_NE(corner.truth.labels[strange], 0);
  int same = 0, board = 0, board_same = 0;
  for (int i = 0; i < corner.grid.size(); ++i) {
    const bool found = labels.labels[i] == corner.truth.labels[i];
    same += found ? 1 : 0;
    if (corner.grid.point(i).x() > 2.5F || corner.truth.labels[i] == 0) continue;
    const bool ahead = std::abs(corner.grid.point(i).x() - 2.2F) < 0.15F && corner.grid.point(i).z() > -0.2F;
    board += ahead ? 1 : 0;
    board_same += ahead && found ? 1 : 0;
  }
  EXPECT_GT(same, 0.985 * corner.grid.size());
  EXPECT_GT(board_same, 0.985 * board);  // ranges tell where it ends, to the pixel
}

}  // namespace
}  // namespace ppc
