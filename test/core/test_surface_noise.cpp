// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_noise.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.01;  // [m]

// A wall to the left and one farther to the right of it, noise of each.
struct TwoWalls {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  LabelImage truth;

  explicit TwoWalls(double left_noise, double right_noise = kSigma, std::uint64_t seed = 3) {
    const auto left = [](const Eigen::Vector3d& p) { return p.y() > 0.1; };
    truth =
        scan({surfaceOf({{Eigen::Vector3d(-1.0, -0.5, 0.0).normalized(), -2.3}, left}), wall({-1.0, 0.1, 0.0}, -2.6)}, grid);
    Normal normal(seed);
    for (int i = 0; i < grid.size(); ++i)
      grid.range[i] += static_cast<float>((truth.labels[i] == 1 ? left_noise : right_noise) * normal());
  }
};

struct Adapted {
  PatchGrid patches;
  NoiseModel noise{SensorModel{kSigma, kSigma, 100.0, 0.0}, 1.0};
  SurfaceNoiseMemory memory;
  bool any = false;

  explicit Adapted(const BeamGrid& grid, double sigma = kSigma, int threads = 1)
      : patches(makePatchGrid(grid, 4, true)), noise(SensorModel{sigma, sigma, 100.0, 0.0}, 1.0) {
    weighPatches(noise, patches);
    any = adaptToSurfaces(grid, patches, noise, memory, threads);
  }

  // The median factor of the pixels of one label, and the share of those that have any.
  double factorOn(const LabelImage& truth, std::int32_t label, double* share = nullptr) const {
    std::vector<float> factors;
    for (int i = 0; i < static_cast<int>(truth.labels.size()); ++i) {
      if (truth.labels[i] == label) factors.push_back(noise.factorAt(i));
    }
    const auto differ = std::count_if(factors.begin(), factors.end(), [](float f) { return f > 1.0F; });
    if (share != nullptr) *share = static_cast<double>(differ) / static_cast<double>(factors.size());
    std::nth_element(factors.begin(), factors.begin() + factors.size() / 2, factors.end());
    return factors[factors.size() / 2];
  }
};

TEST(SurfaceNoise, IsThatOfADarkWallBesideABrightOne) {
  for (const double factor : {2.0, 3.0, 4.0}) {
    const TwoWalls walls(factor * kSigma);
    const Adapted adapted(walls.grid);
    ASSERT_TRUE(adapted.any) << factor;
    double of_dark = 0.0, of_bright = 0.0;
    EXPECT_NEAR(adapted.factorOn(walls.truth, 1, &of_dark), factor, 0.1 * factor);
    EXPECT_EQ(adapted.factorOn(walls.truth, 2, &of_bright), 1.0);
    EXPECT_GT(of_dark, 0.97) << factor;
    EXPECT_LT(of_bright, 0.05) << factor;  // patches that the border of both walls crosses
  }
}

TEST(SurfaceNoise, WeighsThePatchesOfADarkWallAnew) {
  const TwoWalls walls(3.0 * kSigma);
  const Adapted adapted(walls.grid);
  double chi2 = 0.0, freedoms = 0.0;
  for (const Patch& patch : adapted.patches.patches) {
    const int middle =
        walls.grid.index((patch.row_begin + patch.row_end) / 2, std::min(patch.col_begin + 2, walls.grid.cols - 1));
    EXPECT_EQ(patch.noise_factor, adapted.noise.factorAt(middle));
    if (walls.truth.labels[middle] != 1 || patch.moments.n < 8 || !(patch.noise_factor > 2.0)) continue;
    EXPECT_NEAR(patch.fit.chi2, fitPlane(patch.moments).chi2, 1e-6 * patch.moments.w);
    chi2 += patch.fit.chi2;
    freedoms += patch.moments.n - 3;
  }
  ASSERT_GT(freedoms, 5000.0);
  EXPECT_NEAR(chi2 / freedoms, 1.0, 0.1);
}

TEST(SurfaceNoise, IsTypicalWhereAllSurfacesAreAlike) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const TwoWalls walls(kSigma, kSigma, seed);
    const Adapted adapted(walls.grid);
    EXPECT_FALSE(adapted.any) << seed;
  }
}

// What a fine sensor sees of balls is no plane within its noise, by about the same amount from patch to patch.
TEST(SurfaceNoise, IsNotMadeOfBends) {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  scan({ball({2.0, 0.6, 0.0}, 0.35), ball({2.0, -0.5, 0.1}, 0.3), wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  addNoise(grid, 0.0005);
  const Adapted adapted(grid, 0.0005);
  int bent = 0;
  for (const Patch& patch : adapted.patches.patches) bent += patch.fit.chi2 > 2.0 * (patch.moments.n - 3) ? 1 : 0;
  EXPECT_GT(bent, 150);  // or there would be nothing to tell apart
  EXPECT_FALSE(adapted.any);
}

TEST(SurfaceNoise, IsNotMadeOfLeaves) {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  Normal normal(5);
  std::vector<float> depth(static_cast<std::size_t>(grid.size() / 9 + grid.size()));
  for (float& d : depth) d = static_cast<float>(0.3 * normal.uniform());
  for (int i = 0; i < grid.size(); ++i) {
    const int row = i / grid.cols, col = i % grid.cols;
    if (col > 120) grid.range[i] = 2.0F + depth[static_cast<std::size_t>(row / 3 * grid.cols + col / 3)];  // of 3 x 3 pixels
  }
  addNoise(grid, kSigma);
  EXPECT_FALSE(Adapted(grid).any);
}

// Steps seen from afar, several in each patch: from line to line they look like noise, along the lines they do not.
TEST(SurfaceNoise, IsNotMadeOfStairs) {
  BeamGrid grid = forwardBeams(160, 240, 0.25 * kDegree);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  for (int i = 0; i < grid.size(); ++i) {
    if (i % grid.cols > 120 && i / grid.cols % 3 == 0) grid.range[i] += 0.05F;
  }
  addNoise(grid, kSigma);
  const Adapted adapted(grid);
  int rough = 0;
  for (const Patch& patch : adapted.patches.patches) rough += patch.fit.chi2 > 2.0 * (patch.moments.n - 3) ? 1 : 0;
  EXPECT_GT(rough, 300);  // or there would be nothing to tell apart
  EXPECT_FALSE(adapted.any);
}

TEST(SurfaceNoise, DoesNotDependOnThreads) {
  const TwoWalls walls(3.0 * kSigma);
  const Adapted one(walls.grid), three(walls.grid, kSigma, 3);
  EXPECT_EQ(one.memory.pixels, three.memory.pixels);
  Config config;
  const Segmentation by_one = segment(walls.grid, config);
  config.threads = 3;
  EXPECT_EQ(by_one.labels.labels, segment(walls.grid, config).labels.labels);
}

// Whole images: a dark wall is found as one region, and the bright one stays whole.
TEST(SurfaceNoise, ADarkWallIsOneRegion) {
  TwoWalls walls(3.0 * kSigma);
  const auto sharesOf = [&](const Config& config) {
    const Segmentation found = segment(walls.grid, config);
    std::vector<double> shares;
    for (const std::int32_t wall : {1, 2}) {
      std::vector<int> counts(found.regions.size() + 1);
      int all = 0;
      for (int i = 0; i < walls.grid.size(); ++i) {
        if (walls.truth.labels[i] != wall) continue;
        ++counts[static_cast<std::size_t>(found.labels.labels[i])];
        ++all;
      }
      counts[0] = 0;
      shares.push_back(static_cast<double>(*std::max_element(counts.begin(), counts.end())) / all);
    }
    return shares;
  };
  Config config;
  std::vector<double> shares = sharesOf(config);
  EXPECT_GT(shares[0], 0.95);
  EXPECT_GT(shares[1], 0.97);
  config.noise_by_surface = false;
  EXPECT_LT(sharesOf(config)[0], 0.9);
}

}  // namespace
}  // namespace ppc
