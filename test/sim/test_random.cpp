// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/random.h"

#include <gtest/gtest.h>

namespace ppc::sim {
namespace {

TEST(Random, SequenceIsFixedForEver) {
  // The engine is the standard's; these values must come out on every platform, or all seeded scenes change.
  Random random(1);
  EXPECT_DOUBLE_EQ(random.uniform(), 0.55706431627786235);
  EXPECT_DOUBLE_EQ(random.uniform(), 0.68401394458958731);
  EXPECT_DOUBLE_EQ(Random(1, 7).uniform(), 0.58576836682436584);
}

TEST(Random, StreamsAndSeedsAreUnrelated) {
  EXPECT_NE(Random(1).uniform(), Random(2).uniform());
  EXPECT_NE(Random(1, 0).uniform(), Random(1, 1).uniform());
  EXPECT_NE(Random(1, 2).uniform(), Random(2, 1).uniform());
  EXPECT_EQ(Random(5, 6).uniform(), Random(5, 6).uniform());
}

TEST(Random, DistributionsHaveTheirMoments) {
  Random random(2);
  constexpr int kCount = 200000;
  double sum = 0, squares = 0, fourths = 0, uniform = 0;
  int ones = 0, low = 0, high = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
    fourths += x * x * x * x;
    uniform += random.uniform(2, 4);
    ones += random.chance(0.3) ? 1 : 0;
    const int k = random.integer(1, 3);
    ASSERT_TRUE(k >= 1 && k <= 3);
    low += k == 1 ? 1 : 0;
    high += k == 3 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.01);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
  EXPECT_NEAR(fourths / kCount, 3.0, 0.1);
  EXPECT_NEAR(uniform / kCount, 3.0, 0.01);
  EXPECT_NEAR(static_cast<double>(ones) / kCount, 0.3, 0.005);
  EXPECT_NEAR(static_cast<double>(low) / kCount, 1.0 / 3.0, 0.005);
  EXPECT_NEAR(static_cast<double>(high) / kCount, 1.0 / 3.0, 0.005);
}

}  // namespace
}  // namespace ppc::sim
