// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/distance_variance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace ppc {
namespace {

TEST(DistanceVariance, IsThatOfNoiseAndToleranceAtTheRange) {
  const NoiseModel noise(SensorModel{0.001, 0.01, 10.0, 0.001}, 1.0);
  const CoplanarityTolerance tolerance{0.005, 0.005, 1.0};
  DistanceVariance variance;
  variance.set(noise, tolerance);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(0.0F, 150.0F);
  for (int trial = 0; trial < 1000; ++trial) {
    Lanes ranges = {any(random), any(random), any(random), any(random)};
    if (trial == 0)
      ranges = Lanes{0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    const Lanes found = variance.at(ranges);
    for (int k = 0; k < kLanes; ++k) {
      const double sigma = noise.sigma(ranges[k] > 0.0F ? ranges[k] : 0.0F);
      const double floor = tolerance.forNoise(sigma).sigma_distance;
      EXPECT_EQ(found[k], static_cast<float>(sigma * sigma + floor * floor)) << ranges[k];
    }
  }
}

}  // namespace
}  // namespace ppc
