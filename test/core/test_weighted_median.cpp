// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/weighted_median.h"

#include <gtest/gtest.h>
#include <random>

namespace ppc {
namespace {

using Weighted = std::vector<std::pair<float, float>>;

float bySorting(Weighted weighted) {
  std::sort(weighted.begin(), weighted.end());
  float total = 0.0F, below = 0.0F;
  for (const auto& entry : weighted) total += entry.second;
  for (const auto& [value, weight] : weighted) {
    below += weight;
    if (2.0F * below >= total) return value;
  }
  return 0.0F;
}

TEST(WeightedMedian, IsTheOneThatSortingFinds) {
  std::mt19937 random(7);
  for (int n = 0; n < 300; ++n) {
    Weighted weighted;
    // Few different values; whole weights, so that their sums are exact in any order.
    for (int k = 0; k < n; ++k) {
      weighted.emplace_back(static_cast<float>(random() % 97) - 40.0F, static_cast<float>(1 + random() % 9));
    }
    const float expected = bySorting(weighted);
    EXPECT_EQ(weightedMedian(weighted), expected) << n << " values";
  }
}

TEST(WeightedMedian, OfTwoEqualHalvesIsTheLower) {
  Weighted weighted{{5.0F, 2.0F}, {1.0F, 2.0F}};
  EXPECT_EQ(weightedMedian(weighted), 1.0F);
}

}  // namespace
}  // namespace ppc
