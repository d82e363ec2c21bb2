// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_stretches.h"

#include "patch_plane_clustering/core/small_regions.h"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

namespace ppc {
namespace {

// Label, and the beginnings and ends of its stretches.
using Listed = std::vector<std::tuple<std::int32_t, std::vector<int>>>;

Listed listed(const RegionStretches& stretches) {
  Listed result;
  for (const RegionStretches::Region& region : stretches.regions) {
    std::vector<int> ends;
    for (std::size_t s = region.begin; s < region.end; ++s) {
      ends.push_back(stretches.stretches[s].begin);
      ends.push_back(stretches.stretches[s].end);
    }
    result.emplace_back(region.label, ends);
  }
  return result;
}

const std::vector<LabelRun> kRuns = {{3, 0, 2}, {1, 2, 5}, {3, 5, 6}, {2, 7, 9}, {1, 9, 10}, {5, 10, 20}};

TEST(RegionStretches, AreThoseOfTheRegionsWanted) {
  RegionStretches stretches;
  stretches.list(kRuns, 6, [](std::int32_t) { return true; });
  EXPECT_EQ(listed(stretches), (Listed{{1, {2, 5, 9, 10}}, {2, {7, 9}}, {3, {0, 2, 5, 6}}, {5, {10, 20}}}));
  stretches.list(kRuns, 6, [](std::int32_t label) { return label == 5 || label == 1 || label == 4; });
  EXPECT_EQ(listed(stretches), (Listed{{1, {2, 5, 9, 10}}, {5, {10, 20}}}));
  EXPECT_EQ(stretches.stretches.size(), 3U);
  stretches.list({}, 1, [](std::int32_t) { return true; });
  EXPECT_TRUE(stretches.regions.empty());
}

TEST(SmallRegions, HaveFewPointsButEnough) {
  SmallRegions small;
  small.list(kRuns, 3);
  EXPECT_EQ(listed(small), (Listed{{1, {2, 5, 9, 10}}, {3, {0, 2, 5, 6}}, {5, {10, 20}}}));
  EXPECT_EQ(small.points, (std::vector<int>{0, 4, 2, 3, 0, 10}));
  small.list({{2, 0, SmallRegions::kMostPoints}, {1, 5000, 5001 + SmallRegions::kMostPoints}}, 3);
  EXPECT_EQ(listed(small), (Listed{{2, {0, SmallRegions::kMostPoints}}}));
  small.list({}, 3);
  EXPECT_TRUE(small.regions.empty());
}

}  // namespace
}  // namespace ppc
