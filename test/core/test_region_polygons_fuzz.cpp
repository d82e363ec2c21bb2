// SPDX-License-Identifier: BSD-3-Clause
// Whatever the labels, the beams and the noise: every polygon keeps its promises.
#include "patch_plane_clustering/core/region_polygons.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "polygon_test_tools.h"

#include <gtest/gtest.h>
#include <random>

namespace ppc {
namespace {

using namespace testing_tools;

// Labels of random blobs: a sum of random bumps, cut into levels, with some pixels changed at random.
LabelImage randomLabels(int rows, int cols, double speckle, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  LabelImage labels{rows, cols, std::vector<std::int32_t>(static_cast<std::size_t>(rows) * cols)};
  struct Wave {
    double row, col, phase;
  };
  std::vector<Wave> waves(6);
  for (Wave& wave : waves) wave = {0.6 * (unit(random) - 0.5), 0.6 * (unit(random) - 0.5), 2.0 * M_PI * unit(random)};
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      double height = 0.0;
      for (const Wave& wave : waves) height += std::sin(wave.row * r + wave.col * c + wave.phase);
      std::int32_t label = std::max(0, static_cast<int>(std::floor(height)) + 2);
      if (unit(random) < speckle) label = static_cast<int>(4.0 * unit(random));
      labels.labels[r * cols + c] = label;
    }
  }
  return labels;
}

struct Scene {
  BeamGrid grid;
  LabelImage labels;
  std::vector<PlanarRegion> regions;
};

// A plane at a random distance and angle, measured with noise, with random labels on it.
Scene randomScene(double noise, double max_incidence, double speckle, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Scene scene;
  scene.grid = toBeamGrid(noddingScan(50, 70, -30 * kDegree, 30 * kDegree, 40 * kDegree, {0.03 * unit(random), 0.0, 0.05}));
  const double angle = max_incidence * unit(random), about = M_PI * unit(random);
  const Eigen::Vector3d normal(-std::cos(angle), std::sin(angle) * std::cos(about), std::sin(angle) * std::sin(about));
  const double distance = 0.3 + 4.0 * std::abs(unit(random));
  scanFaces({{{normal, -distance}, [](const Eigen::Vector3d& p) { return p.norm() < 50.0; }}}, scene.grid);
  std::normal_distribution<float> error(0.0F, 1.0F);
  for (float& range : scene.grid.range) range += static_cast<float>(noise) * error(random);
  scene.labels = randomLabels(scene.grid.rows, scene.grid.cols, speckle, random);
  scene.regions = describeRegions(scene.grid, scene.labels);
  return scene;
}

class Fuzz : public ::testing::TestWithParam<std::tuple<double, double, double, double>> {};

TEST_P(Fuzz, EveryPolygonIsValidAndAreasAgree) {
  const auto [noise, max_incidence, speckle, tolerance] = GetParam();
  std::mt19937 random(7);
  std::size_t rings = 0;
  for (int round = 0; round < 60; ++round) {
    const Scene scene = randomScene(noise, max_incidence, speckle, random);
    PolygonOptions options;
    options.simplification_tolerance = tolerance;
    const auto polygons = extractPolygons(scene.grid, scene.labels, scene.regions, options);
    options.simplification_tolerance = 0.0;
    const auto full = extractPolygons(scene.grid, scene.labels, scene.regions, options);
    for (const PlanarRegion& region : scene.regions) {
      for (const auto* set : {&polygons, &full}) {
        for (const PlanarPolygon& polygon : *set) {
          if (polygon.id != region.id) continue;
          ASSERT_EQ(faultOf(polygon, region.plane), "") << "round " << round << ", id " << polygon.id;
          rings += 1 + polygon.holes.size();
        }
      }
      const double area = totalArea(full, region.id);
      if (max_incidence > 0.5) continue;  // grazing beams: corners are where the limits put them
      EXPECT_NEAR(totalArea(polygons, region.id), area, 0.05 * area) << "round " << round << ", id " << region.id;
    }
  }
  RecordProperty("rings", static_cast<int>(rings));
  EXPECT_GT(rings, 1000U);
}

INSTANTIATE_TEST_SUITE_P(Labels, Fuzz,
                         ::testing::Values(std::make_tuple(0.0, 0.4, 0.0, 0.02), std::make_tuple(0.0, 0.4, 0.1, 0.02),
                                           std::make_tuple(0.01, 1.2, 0.02, 0.02), std::make_tuple(0.02, 1.2, 0.3, 0.05),
                                           std::make_tuple(0.03, 1.56, 0.05, 0.02), std::make_tuple(0.0, 0.4, 0.05, 0.3)));

}  // namespace
}  // namespace ppc
