// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/similarity.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

TEST(Similarity, IsOneWithoutExcess) {
  EXPECT_DOUBLE_EQ(similarity(0.0, 2.5e5, 0.05, 1.0, {0.005, 0.02, 1.0}), 1.0);
  EXPECT_DOUBLE_EQ(similarity(-1e-9, 2.5e5, 0.05, 1.0, {0.005, 0.02, 1.0}), 1.0);  // rounding
}

TEST(Similarity, NoiseAloneHasThreeDegreesOfFreedom) {
  const CoplanarityTolerance none{0.0, 0.0, 1.0};
  EXPECT_NEAR(similarity(3.0, 2.5e5, 0.05, 1.0, none), std::exp(-0.5), 1e-12);
  EXPECT_NEAR(similarity(6.0 * std::log(10.0), 2.5e5, 0.05, 1.0, none), 0.1, 1e-12);
  const CoplanarityTolerance correlated{0.0, 0.0, 4.0};
  EXPECT_NEAR(similarity(12.0, 2.5e5, 0.05, 1.0, correlated), std::exp(-0.5), 1e-12);
}

// 25 points of 10 mm noise, radius 50 mm: n / sigma^2 = 2.5e5, tau^2 = 0.005^2 + (0.02 * 0.05)^2 = 2.6e-5, product 6.5.
TEST(Similarity, ToleranceAddsToTheNoise) {
  const CoplanarityTolerance tolerance{0.005, 0.02, 1.0};
  EXPECT_NEAR(similarity(19.0, 2.5e5, 0.05, 1.0, tolerance), std::exp(-1.0), 1e-12);           // 2 (3 + 6.5)
  EXPECT_NEAR(similarity(32.0, 2.5e5, 0.05, 2.0, tolerance), std::exp(-1.0), 1e-12);           // 2 (3 + 13)
  EXPECT_NEAR(similarity(18.5, 2.5e5, 0.0, 1.0, tolerance), std::exp(-1.0), 1e-12);            // 2 (3 + 6.25)
  EXPECT_NEAR(similarity(25.0, 2.5e5, 0.05, 1.0, {0.005, 0.02, 2.0}), std::exp(-1.0), 1e-12);  // 2 (6 + 6.5)
}

// A step of delta against a large plane costs n delta^2 / sigma^2; with many points only the tolerance counts.
TEST(Similarity, WithManyPointsIsTheGaussianOfTheDistance) {
  const double precision = 1e6 / (0.01 * 0.01);
  for (const double delta : {0.002, 0.005, 0.015}) {
    const double s = similarity(precision * delta * delta, precision, 0.05, 1.0, {0.005, 0.0, 1.0});
    EXPECT_NEAR(s, std::exp(-0.5 * std::pow(delta / 0.005, 2)), 1e-4);
  }
}

TEST(Similarity, FallsWithExcessAndRisesWithTolerance) {
  double last = 2.0;
  for (const double excess : {0.0, 1.0, 5.0, 20.0, 100.0}) {
    const double s = similarity(excess, 2.5e5, 0.05, 1.0, {0.005, 0.02, 1.0});
    EXPECT_LT(s, last);
    EXPECT_GT(s, 0.0);
    last = s;
  }
  const double s = similarity(20.0, 2.5e5, 0.05, 1.0, {0.005, 0.02, 1.0});
  EXPECT_GT(similarity(20.0, 2.5e5, 0.05, 1.0, {0.006, 0.02, 1.0}), s);
  EXPECT_GT(similarity(20.0, 2.5e5, 0.05, 1.0, {0.005, 0.05, 1.0}), s);
  EXPECT_GT(similarity(20.0, 2.5e5, 0.10, 1.0, {0.005, 0.02, 1.0}), s);
  EXPECT_GT(similarity(20.0, 2.5e5, 0.05, 4.0, {0.005, 0.02, 1.0}), s);
  EXPECT_GT(similarity(20.0, 2.5e5, 0.05, 1.0, {0.005, 0.02, 3.0}), s);
  EXPECT_GT(similarity(20.0, 5.0e5, 0.05, 1.0, {0.005, 0.02, 1.0}), s);
}

TEST(CoplanarityTolerance, OfTheDistanceShrinksForFineSensors) {
  const CoplanarityTolerance tolerance{0.005, 0.02, 2.0};
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.01).sigma_distance, 0.005);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0025).sigma_distance, 0.005);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.00125).sigma_distance, 0.0025);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0).sigma_distance, 0.0015);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0).sigma_angle, 0.02);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0).inflation, 2.0);
}

TEST(CoplanarityTolerance, OfLinesThatAreOffDoesNotShrink) {
  CoplanarityTolerance tolerance{0.0055, 0.02, 1.0};
  tolerance.least_distance = 0.002;
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.01).sigma_distance, 0.0055);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.00125).sigma_distance, 0.00275);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0005).sigma_distance, 0.002);
  EXPECT_DOUBLE_EQ(tolerance.forNoise(0.0005).forNoise(0.0005).sigma_distance, 0.002);
}

// A wall 2 m ahead against one 2.02 m ahead, and against one turned by 0.1 rad about the point where they meet.
TEST(FixedSimilarity, IsTheGaussianOfAngleAndDistance) {
  const CoplanarityTolerance tolerance{0.02, 0.1, 1.0};
  const Eigen::Vector3d near(0.5, 0.0, 0.0), far(1.0 / 2.02, 0.0, 0.0), at(2.0, 0.3, 0.1);
  EXPECT_DOUBLE_EQ(fixedSimilarity(near, near, at, tolerance), 1.0);
  EXPECT_NEAR(fixedSimilarity(near, far, at, tolerance), std::exp(-0.5), 1e-9);
  const Eigen::Vector3d normal(std::cos(0.1), std::sin(0.1), 0.0);
  const Eigen::Vector3d turned = normal / normal.dot(at);
  EXPECT_NEAR(fixedSimilarity(near, turned, at, tolerance), std::exp(-0.5), 1e-9);
  EXPECT_DOUBLE_EQ(fixedSimilarity(near, turned, at, tolerance), fixedSimilarity(turned, near, at, tolerance));
  EXPECT_NEAR(fixedSimilarity(far, turned, at, tolerance), std::exp(-1.0), 1e-9);
}

TEST(SecantSquared, FollowsTheAngleOfIncidenceWithinLimits) {
  EXPECT_DOUBLE_EQ(secantSquared({0.5, 0.0, 0.0}, 2.0), 1.0);    // a wall 2 m ahead, met frontally
  EXPECT_DOUBLE_EQ(secantSquared({0.5, 0.0, 0.0}, 4.0), 4.0);    // the same at 60 deg
  EXPECT_DOUBLE_EQ(secantSquared({0.5, 0.0, 0.0}, 1.9), 1.0);    // noise: nearer than the plane
  EXPECT_DOUBLE_EQ(secantSquared({0.5, 0.0, 0.0}, 50.0), 30.0);  // grazing
}

}  // namespace
}  // namespace ppc
