// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);

PatchGrid gatedPatches(const std::vector<Surface>& surfaces) {
  BeamGrid grid = forwardBeams(80, 120, 0.005);
  scan(surfaces, grid);
  addNoise(grid, 0.01);
  PatchGrid patches = makePatchGrid(grid, 4, true);
  weighPatches(kNoise, patches);
  gatePatches(kNoise, kTolerance, patches);
  return patches;
}

int planarCount(const PatchGrid& patches) {
  int count = 0;
  for (const Patch& patch : patches.patches) count += patch.planar ? 1 : 0;
  return count;
}

const Surface kWall = wall({-1.0, 0.0, 0.0}, -3.0);

TEST(WeighPatches, DividesByTheVarianceOfARange) {
  BeamGrid grid = forwardBeams(4, 4, 0.01);
  scan({kWall}, grid);
  PatchGrid patches = makePatchGrid(grid, 4, false);
  const double unit = patches.patches[0].moments.w;
  weighPatches(kNoise, patches);
  EXPECT_NEAR(patches.patches[0].moments.w, unit * 1e4, 1e-6 * unit * 1e4);
}

TEST(GatePatches, PassesFlatOnesWithTheirPlane) {
  const PatchGrid patches = gatedPatches({kWall});
  const int count = static_cast<int>(patches.patches.size());
  EXPECT_GT(planarCount(patches), 0.98 * count);
  double distance = 0.0;
  for (const Patch& patch : patches.patches) distance += patch.fit.a.dot(Eigen::Vector3d(3.0, 0.0, 0.0)) / count;
  EXPECT_NEAR(distance, 1.0, 0.01);
}

TEST(GatePatches, StopsDepthEdgesAndSparsePatches) {
  BeamGrid grid = forwardBeams(10, 24, 0.005);
  const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.0; };  // columns from 12 on: inside the third strip of 5
  scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.0}, left}), kWall}, grid);
  for (int r = 0; r < 5; ++r) {
    for (int c = 0; c < 5; ++c) {
      if ((5 * r + c) % 4 != 0) grid.range[grid.index(r, c)] = kNoRange;  // 7 of 25 are left
    }
  }
  PatchGrid patches = makePatchGrid(grid, 5, false);
  weighPatches(kNoise, patches);
  gatePatches(kNoise, kTolerance, patches);
  EXPECT_FALSE(patches.patches[patches.patchAt(0, 0)].planar);
  EXPECT_TRUE(patches.patches[patches.patchAt(5, 0)].planar);
  EXPECT_FALSE(patches.patches[patches.patchAt(0, 12)].planar);
  EXPECT_FALSE(patches.patches[patches.patchAt(5, 12)].planar);
  EXPECT_TRUE(patches.patches[patches.patchAt(0, 17)].planar);
}

TEST(EstimateInflation, IsOneForWhiteNoiseAndMoreForCorrelatedNoise) {
  const auto inflation = [](double correlation) {
    BeamGrid grid = forwardBeams(160, 240, 0.005);
    scan({kWall}, grid);
    addNoise(grid, 0.01, 0.0, correlation);
    PatchGrid patches = makePatchGrid(grid, 4, true);
    const NoiseModel noise = NoiseModel::estimate(patches, SensorModel());
    weighPatches(noise, patches);
    gatePatches(noise, kTolerance, patches);
    return estimateInflation(patches);
  };
  EXPECT_NEAR(inflation(0.0), 1.0, 0.1);
  EXPECT_NEAR(inflation(0.5), 1.6, 0.25);  // 1.7 by the mean over all pairs; the low quantile sees less
  EXPECT_NEAR(inflation(0.7), 1.7, 0.25);
}

TEST(EstimateInflation, TooFewPairsAreNoEvidence) { EXPECT_EQ(estimateInflation(PatchGrid()), 1.0); }

TEST(GrowClusters, AWallIsOneCluster) {
  const PatchGrid patches = gatedPatches({kWall});
  const PatchClusters clusters = growClusters(patches, kNoise, kTolerance, 0.1);
  std::size_t largest = 0;
  for (std::size_t id = 0; id < clusters.clusters.size(); ++id) {
    const Cluster& cluster = clusters.clusters[id];
    int points = 0;
    for (int m = cluster.begin; m < cluster.end; ++m) {
      const int k = clusters.members[m];
      EXPECT_EQ(clusters.cluster_of[k], static_cast<int>(id));
      points += patches.patches[k].moments.n;
    }
    EXPECT_EQ(cluster.moments.n, points);
    if (cluster.size() > clusters.clusters[largest].size()) largest = id;
  }
  EXPECT_GT(clusters.clusters[largest].size(), 0.97 * planarCount(patches));
  EXPECT_NEAR(clusters.clusters[largest].fit.distance(), 3.0, 0.001);
  EXPECT_LT((clusters.clusters[largest].fit.normal() + Eigen::Vector3d::UnitX()).norm(), 0.002);
}

TEST(GrowClusters, UngatedPatchesBelongToNoCluster) {
  PatchGrid patches = gatedPatches({kWall});
  patches.patches[17].planar = false;
  const PatchClusters clusters = growClusters(patches, kNoise, kTolerance, 0.1);
  EXPECT_EQ(clusters.cluster_of[17], -1);
}

TEST(GrowClusters, StopsAtAStep) {
  const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.0; };
  const PatchGrid patches = gatedPatches({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.9}, left}), kWall});
  const PatchClusters clusters = growClusters(patches, kNoise, kTolerance, 0.1);
  const int right_cluster = clusters.cluster_of[patches.patchAt(40, 20)];
  const int left_cluster = clusters.cluster_of[patches.patchAt(40, 100)];
  ASSERT_GE(right_cluster, 0);
  ASSERT_GE(left_cluster, 0);
  EXPECT_NE(right_cluster, left_cluster);
  EXPECT_NEAR(clusters.clusters[right_cluster].fit.distance(), 3.0, 0.002);
  EXPECT_NEAR(clusters.clusters[left_cluster].fit.distance(), 2.9, 0.002);
}

TEST(GrowClusters, AHigherThresholdMakesMoreClusters) {
  const PatchGrid patches = gatedPatches({kWall});
  const auto count = [&](double threshold) { return growClusters(patches, kNoise, kTolerance, threshold).clusters.size(); };
  EXPECT_LT(count(0.1), count(0.6));
  EXPECT_LT(count(0.6), count(0.95));
}

// A polygon-like bend: six upright strips, each turned by 5 deg against the one before.
std::vector<Surface> bend() {
  std::vector<Surface> strips;
  Eigen::Vector2d corner(3.0, -1.2);
  for (int k = 0; k < 6; ++k) {
    const double turn = 5.0 * kDegree * (k - 2.5);
    const Eigen::Vector3d normal(-std::cos(turn), -std::sin(turn), 0.0);
    const Eigen::Vector2d next = corner + 0.4 * Eigen::Vector2d(-std::sin(turn), std::cos(turn));
    const double low = corner.y(), high = next.y();
    strips.push_back(surfaceOf(
        {{normal, normal.head<2>().dot(corner)}, [=](const Eigen::Vector3d& p) { return p.y() >= low && p.y() < high; }}));
    corner = next;
  }
  return strips;
}

TEST(GrowClusters, AgainstTheNeighbourAloneItCreepsRoundABend) {
  const PatchGrid patches = gatedPatches(bend());
  const auto largest = [&](bool running_plane) {
    int size = 0;
    for (const Cluster& cluster : growClusters(patches, kNoise, kTolerance, 0.1, {running_plane, true}).clusters) {
      size = std::max(size, cluster.size());
    }
    return static_cast<double>(size) / planarCount(patches);
  };
  EXPECT_LT(largest(true), 0.5);
  EXPECT_GT(largest(false), 0.9);
}

TEST(GrowClusters, FixedGaussiansKnowNothingOfNoise) {
  const PatchGrid patches = gatedPatches({kWall});  // 10 mm noise on patches of 6 cm: their planes differ by degrees
  const auto count = [&](const CoplanarityTolerance& tolerance, bool noise_aware, bool running_plane) {
    return growClusters(patches, kNoise, tolerance, 0.1, {running_plane, noise_aware}).clusters.size();
  };
  const std::size_t few = count(kTolerance, true, true);
  EXPECT_GT(count(kTolerance, false, true), 20 * few);
  EXPECT_GT(count(kTolerance, false, false), 20 * few);
  EXPECT_LT(count({0.05, 0.8, 1.0}, false, true), 2 * few);
}

}  // namespace
}  // namespace ppc
