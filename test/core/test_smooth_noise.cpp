// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/smooth_noise.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/grid_selection.h"
#include "patch_plane_clustering/core/image_errors.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 360, kCols = 480;
constexpr double kStep = 0.15 * kDegree, kTolerance = 0.005;  // [m]

// A wall ahead, a floor, a wall to the left and a board before the wall.
struct Corner {
  BeamGrid grid;
  LabelImage truth;
  int faces;

  explicit Corner(BeamGrid beams = forwardBeams(kRows, kCols, kStep)) : grid(std::move(beams)) {
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
  EXPECT_FALSE(thinSmoothNoise(coarse.grid, 0.0001, memory));
}

TEST(SmoothNoise, IsNoneOfErrorsAlongLinesOrBetweenNeighbours) {
  SmoothNoiseMemory memory;
  Corner lines, neighbours;
  addNoise(lines.grid, 0.02, 0.0, 0.95);
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
  BeamGrid corrugated = forwardBeams(kRows, kCols, kStep);
  scan({relief([](double y) { return 3.0 - 0.03 * std::sin(30.0 * y); })}, corrugated);
  addNoise(corrugated, 0.001);
  EXPECT_FALSE(thinSmoothNoise(corrugated, kTolerance, memory));  // along columns it is straight
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
  for (const int rows : {16, 70}) {  // of 70, less than 40 would be left
    BeamGrid low = forwardBeams(rows, kCols, kStep);
    scan({wall({-1.0, 0.0, 0.0}, -3.0)}, low);
    addSmoothNoise(low, 0.03, 3.0);
    EXPECT_FALSE(thinSmoothNoise(low, kTolerance, memory)) << rows;
  }
}

TEST(SmoothNoise, IsThinnedByMoreThePixelsItIsAlikeOver) {
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

// The region that has most of a true face, and how much of it.
std::pair<std::int32_t, double> mostOf(const Corner& corner, std::int32_t face, const LabelImage& labels) {
  std::map<std::int32_t, int> counts;
  for (int i = 0; i < corner.grid.size(); ++i) counts[labels.labels[i]] += corner.truth.labels[i] == face ? 1 : 0;
  counts.erase(0);
  const auto most = std::max_element(counts.begin(), counts.end(), [](auto& a, auto& b) { return a.second < b.second; });
  return {most->first, static_cast<double>(most->second) / countOf(corner.truth, face)};
}

// A region for each face, and scraps at most beside.
void expectFaces(const Corner& corner, const Segmentation& found) {
  ASSERT_GE(found.regions.size(), static_cast<std::size_t>(corner.faces));
  for (std::size_t k = corner.faces; k < found.regions.size(); ++k) EXPECT_LT(found.regions[k].points, 2000);
  std::set<std::int32_t> regions;
  for (std::int32_t face = 1; face <= corner.faces; ++face) {
    const auto [region, share] = mostOf(corner, face, found.labels);
    EXPECT_GT(share, 0.9) << face;
    regions.insert(region);
  }
  EXPECT_EQ(regions.size(), static_cast<std::size_t>(corner.faces));
}

TEST(SmoothNoise, LeavesWallsWholeThatWouldFallIntoBumps) {
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  Config config;
  config.thin_smooth_noise = false;
  EXPECT_GT(segment(corner.grid, config).regions.size(), 20U);
  const Segmentation found = segment(corner.grid, Config());
  expectFaces(corner, found);
  config = Config();
  config.threads = 3;
  EXPECT_EQ(segment(corner.grid, config).labels.labels, found.labels.labels);
}

TEST(SmoothNoise, SizesAreThoseOfTheWholeImage) {
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  Config config;
  config.min_size = countOf(corner.truth, corner.faces) / 2;  // of the smallest face
  const Segmentation found = segment(corner.grid, config);
  EXPECT_EQ(found.regions.size(), static_cast<std::size_t>(corner.faces));
  expectFaces(corner, found);
}

TEST(SmoothNoise, IsThinnedAlsoOfBeamsThatBeginAnywhereAndOfPointsThatAreMissing) {
  const double height = 0.5 * (kRows - 1) * kStep, width = 0.5 * (kCols - 1) * kStep;
  Corner corner(toBeamGrid(noddingScan(kRows, kCols, -height, height, width, {0.1, 0.0, 0.2})));
  addSmoothNoise(corner.grid, 0.03, 3.0);
  Normal normal(7);
  for (int i = 0; i < corner.grid.size(); ++i) {
    if (normal.uniform() < 0.01) corner.grid.range[i] = kNoRange;
  }
  ClusteringMemory memory;
  Segmentation found;
  segment(corner.grid, Config(), memory, found);
  ASSERT_GT(memory.smooth.stride, 1);
  expectFaces(corner, found);
  const std::vector<std::int32_t> labels = found.labels.labels;
  const Corner exact;  // the same memory serves images that are not thinned
  segment(exact.grid, Config(), memory, found);
  EXPECT_EQ(memory.smooth.stride, 1);
  EXPECT_EQ(found.labels.labels, segment(exact.grid, Config()).labels.labels);
  segment(corner.grid, Config(), memory, found);
  EXPECT_EQ(found.labels.labels, labels);
}

TEST(SmoothNoise, IsThinnedAlsoWhereLinesStand) {
  std::vector<int> rows, cols(kCols);
  std::iota(cols.begin(), cols.end(), 0);
  for (int row = 0; row < kRows; ++row) rows.insert(rows.end(), row == 100 ? 30 : 1, row);
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  BeamGrid waits;
  selectBeams(corner.grid, rows, cols, waits);
  waits.beams_exact = false;
  ClusteringMemory memory;
  Segmentation found;
  segment(waits, Config(), memory, found);
  EXPECT_EQ(memory.standing.grid.rows, kRows);
  EXPECT_GT(memory.smooth.stride, 1);
  ASSERT_GE(found.regions.size(), static_cast<std::size_t>(corner.faces));
  EXPECT_LT(found.regions.size(), 8U);
  EXPECT_GT(found.regions[0].points, 0.9 * countOf(corner.truth, 1));  // the wall ahead
}

ImageErrors errorsOf(const Corner& corner, const Config& config, ClusteringMemory& memory) {
  measureSteps(corner.grid, memory.patch_grids, memory.steps, 1);
  makePatchGrid(corner.grid, config.patch_size, memory.steps, nullptr, 1, memory.patch_grids, memory.patches);
  return estimateErrors(corner.grid, 0.0, config, memory);
}

TEST(SmoothNoise, ErrorsOfRangeCamerasAreAlikeAround) {
  SmoothNoiseMemory memory;
  Corner independent, lines, camera;
  addNoise(independent.grid, 0.01);
  EXPECT_FALSE(areErrorsAlikeAround(independent.grid, memory));
  addNoise(lines.grid, 0.01, 0.0, 0.8);
  EXPECT_FALSE(areErrorsAlikeAround(lines.grid, memory));
  addSmoothNoise(camera.grid, 0.01, 0.7);
  EXPECT_TRUE(areErrorsAlikeAround(camera.grid, memory));
  EXPECT_FALSE(thinSmoothNoise(camera.grid, kTolerance, memory));
  EXPECT_FALSE(areErrorsAlikeAround(BeamGrid(), memory));
  ClusteringMemory clustering;
  for (Corner* corner : {&independent, &lines, &camera}) {
    const ImageErrors errors = errorsOf(*corner, Config(), clustering);
    EXPECT_EQ(errors.tolerance.alike_around, corner == &camera);
    EXPECT_EQ(errors.tolerance.isWhite(), corner == &independent);
  }
}

TEST(SmoothNoise, LabelsPixelsBetweenThoseOfTheThinnedImage) {
  Corner corner;
  addSmoothNoise(corner.grid, 0.03, 3.0);
  SmoothNoiseMemory memory;
  ASSERT_TRUE(thinSmoothNoise(corner.grid, kTolerance, memory));
  memory.labels.labels.clear();
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
