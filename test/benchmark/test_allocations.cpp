// SPDX-License-Identifier: BSD-3-Clause
// Memory is kept from one image to the next: a frame after the first asks nothing of the system, by one thread.
#include "patch_plane_clustering/core/polygon_memory.h"
#include "patch_plane_clustering/core/region_polygons.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"

#include "../core/analytic_scenes.h"
#include "allocations.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

template <typename Work>
std::int64_t allocationsOf(const Work& work) {
  return bench::memoryOf(work).allocations;
}

// A room in which some walls meet, some are split by noise, and a few pieces are cut out of others.
RangeImage noisyRoom() {
  constexpr int kRows = 200, kCols = 240;
  constexpr double kStep = 0.004;
  RangeImage image =
      noddingScan(kRows, kCols, -0.5 * (kRows - 1) * kStep, 0.5 * (kRows - 1) * kStep, 0.5 * (kCols - 1) * kStep);
  BeamGrid grid = toBeamGrid(image);
  scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, -1.0, 0.0}, -0.8), wall({0.0, 0.0, 1.0}, -0.6),
        wall({-1.0, -0.6, 0.1}, -2.8)},
       grid);
  addNoise(grid, 0.02);
  image.ranges = grid.range;
  return image;
}

class Allocations : public ::testing::Test {
 protected:
  const RangeImage image_ = noisyRoom();
  const Config config_;
  BeamColumns columns_;
  BeamGrid grid_;
  ClusteringMemory memory_;
  Segmentation result_;
};

TEST_F(Allocations, FromRangesToLabelsAreNoneAfterTheFirstFrame) {
  const auto frame = [&] {
    toBeamGrid(image_, columns_, grid_);
    clusterPatches(grid_, config_, memory_, result_.labels, nullptr);
  };
  EXPECT_GT(allocationsOf(frame), 0);
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsOf(frame), 0) << "in frame " << k;
}

TEST_F(Allocations, FromRangesToPolygonsAreNoneAfterTheFirstFrame) {
  const auto frame = [&] {
    toBeamGrid(image_, columns_, grid_);
    segment(grid_, config_, memory_, result_);
  };
  frame();
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsOf(frame), 0) << "in frame " << k;
}

TEST_F(Allocations, OfSmoothNoiseAreNoneAfterTheFirstFrame) {
  grid_ = forwardBeams(300, 400, 0.0025);
  scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.6)}, grid_);
  addSmoothNoise(grid_, 0.03, 3.0);
  const auto frame = [&] { segment(grid_, config_, memory_, result_); };
  frame();
  ASSERT_GT(memory_.smooth.stride, 1);
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsOf(frame), 0) << "in frame " << k;
}

TEST_F(Allocations, OfStepsLowerThanNoiseAreNoneAfterTheFirstFrame) {
  grid_ = forwardBeams(160, 240, 0.004);
  scanPaneBehind(0.03, grid_);
  addNoise(grid_, 0.04);
  const auto frame = [&] { segment(grid_, config_, memory_, result_); };
  frame();
  ASSERT_FALSE(memory_.low_steps.steps.empty());
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsOf(frame), 0) << "in frame " << k;
}

// A cloud in which the motor waits, and half of what is seen is dark.
TEST_F(Allocations, OfWaitingMotorsAndDarkSurfacesAreNoneAfterTheFirstFrame) {
  RangeImage image = image_;
  for (int r = 60; r < 80; ++r) image.line_poses[r] = image.line_poses[60];
  toBeamGrid(image, columns_, grid_);
  grid_.beams_exact = false;
  grid_.range.assign(grid_.range.size(), kNoRange);
  scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, 0.0, 1.0}, -0.6)}, grid_);
  Normal normal(1);
  for (int i = 0; i < grid_.size(); ++i)
    grid_.range[i] += static_cast<float>((i % grid_.cols < 80 ? 0.03 : 0.01) * normal());
  const auto frame = [&] { segment(grid_, config_, memory_, result_); };
  frame();
  ASSERT_EQ(memory_.standing.grid.rows, grid_.rows - 19);
  ASSERT_EQ(memory_.surface_noise.pixels.size(), memory_.standing.grid.range.size());
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsOf(frame), 0) << "in frame " << k;
}

class PolygonAllocations : public Allocations {
 protected:
  PolygonAllocations() {
    toBeamGrid(image_, columns_, grid_);
    segment(grid_, config_, memory_, result_);
  }

  std::int64_t allocationsInto(std::vector<PlanarPolygon>& polygons) {
    return allocationsOf([&] {
      extractPolygons(grid_, result_.labels, memory_.finishing.runs, result_.regions, config_.polygons,
                      memory_.finishing.polygons, polygons);
    });
  }
};

TEST_F(PolygonAllocations, AreNoneIfThoseOfTheLastFrameAreHandedIn) {
  ASSERT_GE(result_.polygons.size(), 3U);
  for (int k = 1; k < 4; ++k) EXPECT_EQ(allocationsInto(result_.polygons), 0) << "in frame " << k;
}

// What is returned: an array for each ring, one for the holes of each polygon, and the list of all.
TEST_F(PolygonAllocations, AreThoseThatAreReturned) {
  std::vector<PlanarPolygon> polygons;
  const std::int64_t made = allocationsInto(polygons);
  std::int64_t returned = 1;
  for (const PlanarPolygon& polygon : polygons) {
    returned += 1 + (polygon.holes.empty() ? 0 : 1) + static_cast<std::int64_t>(polygon.holes.size());
  }
  EXPECT_EQ(made, returned);
}

}  // namespace
}  // namespace ppc
