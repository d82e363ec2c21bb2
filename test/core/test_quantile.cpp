// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/quantile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace ppc {
namespace {

template <typename T>
void expectSortedValues(const std::vector<T>& values) {
  std::vector<T> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t step = std::max<std::size_t>(1, values.size() / 40);
  for (std::size_t rank = 0; rank < values.size(); rank += step) {
    std::vector<T> shuffled = values;
    ASSERT_EQ(valueOfRank(shuffled, rank), sorted[rank]) << "of " << values.size() << " at " << rank;
    std::sort(shuffled.begin(), shuffled.end());
    ASSERT_EQ(shuffled, sorted);  // none is lost
  }
}

TEST(Quantile, IsTheValueInSortedOrder) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const std::size_t n : {1U, 2U, 15U, 16U, 17U, 18U, 100U, 1001U}) {
    std::vector<float> numbers(n), few(n), sorted(n), falling(n), organ(n);
    std::vector<double> wide(n);
    for (std::size_t i = 0; i < n; ++i) {
      numbers[i] = static_cast<float>(normal(random));
      few[i] = static_cast<float>(random() % 3);
      sorted[i] = static_cast<float>(i);
      falling[i] = -sorted[i];
      organ[i] = static_cast<float>(std::min(i, n - i));
      wide[i] = std::exp(10.0 * normal(random));
    }
    for (const auto& values : {numbers, few, sorted, falling, organ, std::vector<float>(n, 1.0F)})
      expectSortedValues(values);
    expectSortedValues(wide);
  }
}

TEST(Quantile, TakesTheUpperOfTwoMiddleValues) {
  std::vector<double> values{4.0, 1.0, 3.0, 2.0};
  EXPECT_EQ(median(values), 3.0);
  EXPECT_EQ(quantile(values, 0.0), 1.0);
  EXPECT_EQ(quantile(values, 1.0), 4.0);
}

}  // namespace
}  // namespace ppc
