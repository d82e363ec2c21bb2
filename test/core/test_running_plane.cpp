// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/running_plane.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace ppc {
namespace {

constexpr double kSigma = 0.01;
constexpr double kGreatest = 4.6;

/// Points of a wall at x = 3 m + offset, one metre wide and high around (y, z), seen with noise.
Moments wall(double y, double z, double offset, int points, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kSigma);
  std::uniform_real_distribution<double> anywhere(-0.05, 0.05);
  Moments m;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d truth(3.0 + offset, y + anywhere(random), z + anywhere(random));
    const Eigen::Vector3d p = truth * (1.0 + noise(random) / truth.norm());
    m.add(p.x(), p.y(), p.z(), p.squaredNorm() / (kSigma * kSigma));
  }
  return m;
}

bool exactly(const Moments& cluster, const Moments& piece, const CoplanarityTolerance& tolerance) {
  const PlaneFit joint = fitPlane(cluster + piece);
  const double excess = joint.chi2 - fitPlane(cluster).chi2 - fitPlane(piece).chi2;
  return misfit(excess, piece.n / (kSigma * kSigma), piece.radius(), secantSquared(joint.a, 3.0), tolerance) <= kGreatest;
}

TEST(RunningPlane, DecidesAsTheJointFitDoes) {
  std::mt19937 random(1);
  const CoplanarityTolerance tolerance{0.005, 0.005, 1.0};
  int differ = 0, joined = 0, left_out = 0;
  for (int run = 0; run < 20; ++run) {
    const Moments seed = wall(0.0, 0.0, 0.0, 12, random);
    RunningPlane plane(seed, fitPlane(seed));
    Moments naive = seed;
    for (int i = 1; i < 200; ++i) {
      const double offset = i % 10 == 9 ? 0.004 * (i % 17) : 0.0;
      const Moments piece = wall(0.1 * (i % 14), 0.1 * (i / 14), offset, 12, random);
      const bool suits =
          plane.suits({piece, fitPlane(piece), piece.radius(), 3.0, kSigma, double(piece.n)}, tolerance, kGreatest);
      differ += suits != exactly(naive, piece, tolerance) ? 1 : 0;
      (suits ? joined : left_out) += 1;
      if (!suits) continue;
      plane.join(piece);
      naive += piece;
    }
    const PlaneFit truth = fitPlane(naive);
    EXPECT_EQ(plane.moments().n, naive.n);
    EXPECT_LT((plane.fit().a - truth.a).norm(), 1e-12 * truth.a.norm());
    EXPECT_NEAR(plane.fit().chi2, truth.chi2, 1e-9 * truth.chi2);
  }
  EXPECT_GT(joined, 3000);
  EXPECT_GT(left_out, 100);
  EXPECT_LE(differ, 4);  // a plane that lags behind decides otherwise at the very limit alone
}

TEST(RunningPlane, SmallClustersAreAlwaysComparedByTheJointPlane) {
  std::mt19937 random(2);
  const CoplanarityTolerance tolerance{0.005, 0.005, 1.0};
  for (int i = 0; i < 100; ++i) {
    const Moments a = wall(0.0, 0.0, 0.0, 12, random), b = wall(0.1, 0.0, 0.001 * i, 12, random);
    RunningPlane plane(a, fitPlane(a));
    const bool suits = plane.suits({b, fitPlane(b), b.radius(), 3.0, kSigma, double(b.n)}, tolerance, kGreatest);
    EXPECT_EQ(suits, exactly(a, b, tolerance)) << i;
  }
}

}  // namespace
}  // namespace ppc
