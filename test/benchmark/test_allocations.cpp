// SPDX-License-Identifier: BSD-3-Clause
// Memory is kept from one image to the next: what a frame after the first asks of the system stays within bounds.
#include "patch_plane_clustering/core/segmenter.h"

#include "../core/analytic_scenes.h"
#include "allocations.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <utility>

namespace ppc {
namespace {

using namespace testing_tools;

template <typename Work>
std::int64_t allocationsOf(const Work& work) {
  return bench::memoryOf(work).allocations;
}

// A room in which some walls meet, some are split by noise, and a few pieces are cut out of others.
BeamGrid noisyRoom() {
  BeamGrid grid = forwardBeams(200, 240, 0.004);
  scan({wall({-1.0, 0.1, 0.0}, -3.0), wall({0.0, -1.0, 0.0}, -0.8), wall({0.0, 0.0, 1.0}, -0.6),
        wall({-1.0, -0.6, 0.1}, -2.8)},
       grid);
  addNoise(grid, 0.02);
  return grid;
}

class Allocations : public ::testing::Test {
 protected:
  const BeamGrid grid_ = noisyRoom();
  const Config config_;
  ClusteringMemory memory_;
};

// Of a frame without memory there are many times as many.
TEST_F(Allocations, OfLabelsAreFewAfterTheFirstFrame) {
  const auto frame = [&] { clusterPatches(grid_, config_, memory_, nullptr); };
  const std::int64_t first = allocationsOf(frame);
  const std::int64_t second = allocationsOf(frame);
  RecordProperty("second", static_cast<int>(second));
  EXPECT_LE(second, 300) << "of " << first << " in the first";
  EXPECT_GT(first, 2 * second);
  EXPECT_EQ(allocationsOf(frame), second);
}

// What is returned: an array for each ring, one for the holes of each polygon, and the lists of all.
TEST_F(Allocations, OfPolygonsAreThoseThatAreReturned) {
  segment(grid_, config_, memory_);
  LabelImage labels = clusterPatches(grid_, config_, memory_, nullptr);
  Segmentation result;
  const std::int64_t made =
      allocationsOf([&] { result = finishSegmentation(grid_, std::move(labels), config_, {}, memory_.finishing); });
  std::int64_t returned = 2;  // lists of regions and polygons
  for (const PlanarPolygon& polygon : result.polygons) {
    returned += 1 + (polygon.holes.empty() ? 0 : 1) + static_cast<std::int64_t>(polygon.holes.size());
  }
  RecordProperty("made", static_cast<int>(made));
  ASSERT_GE(result.polygons.size(), 3U);
  EXPECT_LE(made, returned + 60) << returned << " are returned";
}

}  // namespace
}  // namespace ppc
