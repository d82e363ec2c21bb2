// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_split.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace ppc {
namespace {

constexpr double kSigma = 0.01;
const NoiseModel kNoise(SensorModel{kSigma, kSigma, 10.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};

// Points of a wall at x = `distance`, turned about y = 0, between two bearings.
Moments wallBetween(double from, double to, double distance, double turn = 0.0) {
  std::mt19937 random(7);
  std::normal_distribution<double> error(0.0, kSigma);
  Moments sum;
  for (double elevation = -0.2; elevation < 0.2; elevation += 0.01) {
    for (double bearing = from; bearing < to; bearing += 0.005) {
      const Eigen::Vector3d beam = Eigen::Vector3d(std::cos(bearing) * std::cos(elevation),
                                                   std::sin(bearing) * std::cos(elevation), std::sin(elevation));
      const double range = distance / (beam.x() + turn * beam.y()) + error(random);
      const Eigen::Vector3d p = range * beam;
      sum.add(p.x(), p.y(), p.z(), range * range / (kSigma * kSigma));
    }
  }
  return sum;
}

LabelSplit splitOf(const Moments& low, const Moments& high) {
  LabelSplit split;
  split.low.sum = low;
  split.high.sum = high;
  split.fit();
  return split;
}

TEST(LabelSplit, TellsAStepAndATurnFromOnePlane) {
  const Moments left = wallBetween(0.0, 0.3, 3.0);
  for (const auto& [distance, turn] : {std::pair{3.0, 0.0}, {3.03, 0.0}, {3.0, 0.3}}) {
    const Moments right = wallBetween(-0.3, 0.0, distance, turn);
    const LabelSplit split = splitOf(left, right);
    const PlaneFit whole = fitPlane(left + right);
    const bool one = distance == 3.0 && turn == 0.0;
    EXPECT_EQ(split.areParallel(), turn == 0.0);
    EXPECT_EQ(split.isBeyond(kTolerance, kNoise, whole), !one);
    EXPECT_EQ(split.explained(whole) < 20.0, one);
    EXPECT_NEAR(split.explained(whole), whole.chi2 - fitPlane(left).chi2 - fitPlane(right).chi2, 1e-9);
    EXPECT_LT(split.leftOver(), split.noise(kTolerance));
  }
}

TEST(LabelSplit, LeavesWhatAThirdPlaneHas) {
  const Moments three = wallBetween(-0.3, -0.15, 3.0) + wallBetween(-0.15, 0.0, 3.2);
  const LabelSplit split = splitOf(wallBetween(0.0, 0.1, 2.9), three);
  EXPECT_GT(split.leftOver(), split.noise(kTolerance));
  EXPECT_EQ(split.smaller(), split.low.sum.n);
}

TEST(LabelSplit, NoiseLeavesMoreWhereErrorsAreCorrelated) {
  const LabelSplit split = splitOf(wallBetween(0.0, 0.1, 3.0), wallBetween(-0.3, 0.0, 3.0));
  CoplanarityTolerance correlated = kTolerance;
  correlated.inflation = 4.0;
  EXPECT_NEAR(split.noise(correlated), 2.0 * split.noise(kTolerance), 1e-9);
}

}  // namespace
}  // namespace ppc
