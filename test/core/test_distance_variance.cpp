// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/distance_variance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

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
    const Lanes found = variance.at(ranges, 0);
    for (int k = 0; k < kLanes; ++k) {
      const double sigma = noise.sigma(ranges[k] > 0.0F ? ranges[k] : 0.0F);
      const double floor = tolerance.forNoise(sigma).sigma_distance;
      EXPECT_EQ(found[k], static_cast<float>(sigma * sigma + floor * floor)) << ranges[k];
    }
  }
}

TEST(DistanceVariance, IsLargerOnSurfacesOfMoreNoise) {
  NoiseModel noise(SensorModel{0.001, 0.01, 10.0, 0.001}, 1.0);
  const std::vector<float> factors = {1.0F, 3.0F};
  noise.setFactors(factors);
  const CoplanarityTolerance tolerance{0.005, 0.005, 1.0};
  DistanceVariance variance;
  variance.set(noise, tolerance);
  for (int pixel = 0; pixel < 2; ++pixel) {
    const Lanes found = variance.at(Lanes{0.5F, 2.0F, 9.0F, 50.0F}, pixel);
    const float ranges[] = {0.5F, 2.0F, 9.0F, 50.0F};
    for (int k = 0; k < kLanes; ++k) {
      const double sigma = noise.sigmaAt(pixel, ranges[k]), floor = tolerance.forNoise(sigma).sigma_distance;
      EXPECT_DOUBLE_EQ(sigma, factors[static_cast<std::size_t>(pixel)] * noise.sigma(ranges[k]));
      EXPECT_NEAR(found[k], sigma * sigma + floor * floor, 1e-3 * found[k]) << pixel << " " << ranges[k];
    }
  }
}

}  // namespace
}  // namespace ppc
