// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/near_fit.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.01;  // [m]
const NoiseModel kNoise(SensorModel{kSigma, kSigma, 100.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance{0.0, 0.0, 1.0};
const Eigen::Vector3d kNormal = Eigen::Vector3d(-1.0, 0.3, 0.1).normalized();

// A plane 2 m away, 30 x 40 points.
struct Scene {
  BeamGrid grid = forwardBeams(30, 40, 0.01);
  std::vector<RegionPoint> points;

  explicit Scene(const Surface& surface = wall(kNormal, -2.0)) {
    scan({surface}, grid);
    addNoise(grid, kSigma);
  }
  NearFit fit(const std::vector<PixelStretch>& stretches) {
    return fitNear({grid, Eigen::Vector3d::Zero(), kNoise, kTolerance, 0}, stretches.data(),
                   stretches.data() + stretches.size(), points);
  }
  NearFit fitAll() { return fit({{0, grid.size()}}); }
};

double degreesOff(const NearFit& fit) { return std::acos(std::min(1.0, -fit.a.normalized().dot(kNormal))) / kDegree; }

TEST(FitNear, TakesAllPointsThatNoiseExplains) {
  Scene scene;
  const NearFit fit = scene.fitAll();
  EXPECT_EQ(NearFit::Of::kAll, fit.of);
  EXPECT_LT(degreesOff(fit), 0.3);
  EXPECT_NEAR(2.0, 1.0 / fit.a.norm(), 0.003);
  EXPECT_NEAR(kSigma, fit.sigma, 1e-9);
  EXPECT_NEAR(kSigma, fit.noise, 1e-9);
  EXPECT_EQ(1200U, scene.points.size());
}

TEST(FitNear, LeavesOutliersOut) {
  Scene scene;
  for (int i = 0; i < scene.grid.size(); i += 20) scene.grid.range[i] -= 0.15F;
  for (int r = 0; r < 30; ++r) scene.grid.range[scene.grid.index(r, 0)] += 0.2F;  // a column of something else
  const NearFit fit = scene.fitAll();
  EXPECT_EQ(NearFit::Of::kNear, fit.of);
  EXPECT_LT(degreesOff(fit), 0.3);
  EXPECT_GT(fit.radius, 0.1);
  EXPECT_LT(fit.radius, 0.5);
}

TEST(FitNear, WantsFourMeasurements) {
  Scene scene;
  EXPECT_EQ(NearFit::Of::kFew, scene.fit({{0, 3}}).of);
  EXPECT_EQ(NearFit::Of::kFew, scene.fit({}).of);
  for (int i = 3; i < 40; ++i) scene.grid.range[i] = kNoRange;
  EXPECT_EQ(NearFit::Of::kFew, scene.fit({{0, 40}}).of);
  EXPECT_EQ(3U, scene.points.size());
}

TEST(FitNear, FindsNoneBetweenTwoSheets) {
  Scene scene;
  for (int i = 0; i < scene.grid.size(); ++i) scene.grid.range[i] += (i + i / 40) % 2 == 0 ? 0.3F : -0.3F;
  EXPECT_EQ(NearFit::Of::kNone, scene.fitAll().of);
}

TEST(IsExplained, TellsAPlaneFromABend) {
  Scene flat, bent(relief([](double y) { return 2.0 + 0.5 * std::abs(y); }));
  const auto one = [](const RegionPoint&) { return 1.0; };
  NearFit fit = flat.fitAll();
  EXPECT_TRUE(isExplained(flat.points, fit.a, one));
  fit = bent.fitAll();
  EXPECT_FALSE(isExplained(bent.points, fit.a, one));
  EXPECT_TRUE(isExplained(bent.points, fit.a, [](const RegionPoint&) { return 100.0; }));
}

TEST(RegionPoint, IsFarthestFromAPlaneThatItsBeamMisses) {
  const RegionPoint point{{2.0, 0.0, 0.0}, 4.0 / (kSigma * kSigma), 0};
  EXPECT_NEAR(0.0, point.squaredError({0.5, 0.0, 0.0}), 1e-9);
  EXPECT_NEAR(1.0, point.squaredError({1.0 / (2.0 + kSigma), 0.0, 0.0}), 1e-6);
  EXPECT_TRUE(std::isinf(point.squaredError({-0.5, 0.0, 0.0})));
  EXPECT_TRUE(std::isinf(point.squaredError({0.0, 1.0, 0.0})));
}

}  // namespace
}  // namespace ppc
