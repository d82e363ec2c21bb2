// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_samples.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);

// Two walls, some of whose pixels have no measurement: label 1 above, 2 below, and 3 on two pixels.
struct Scene {
  BeamGrid grid = forwardBeams(90, 120, 0.005);
  LabelImage labels;
  SampleMemory memory;

  Scene() {
    labels = scan({wall({-1.0, 0.3, 0.1}, -3.0)}, grid);
    addNoise(grid, 0.01);
    for (int i = 0; i < grid.size(); ++i) {
      labels.labels[i] = i < grid.size() / 3 ? 1 : 2;
      if (i % 7 == 3) grid.range[i] = std::numeric_limits<float>::quiet_NaN();
    }
    labels.labels[0] = labels.labels[1] = 3;
    chooseSamples(grid, labelRuns(labels), memory);
    SampledBeams beams;
    for (int label = 0; label < 4; ++label) {
      if (memory.regions[label].points > 0) sampleRegion(grid, kNoise, label, beams, memory);
    }
  }

  // Plainly: every stride-th pixel of a label, as far as it has a measurement.
  std::vector<int> pixelsOf(int label) const {
    std::vector<int> pixels;
    int count = 0;
    for (int i = 0; i < grid.size(); ++i) {
      if (labels.labels[i] != label) continue;
      if (count++ % memory.regions[label].stride == 0 && grid.valid(i)) pixels.push_back(i);
    }
    return pixels;
  }
};

TEST(RegionSamples, AreTakenEvenlyFromEachLabel) {
  const Scene scene;
  EXPECT_EQ(scene.memory.regions[1].stride, 2);  // of 3598
  EXPECT_EQ(scene.memory.regions[2].stride, 4);
  for (int label = 1; label < 4; ++label) {
    const auto begin = scene.memory.pixels.begin();
    const std::vector<int> found(begin + scene.memory.begin[label], begin + scene.memory.end[label]);
    EXPECT_EQ(found, scene.pixelsOf(label));
  }
  EXPECT_EQ(scene.memory.regions[3].points, 0);  // too few for a plane
}

TEST(RegionSamples, LieAboutTheirPlaneWithTheirNoise) {
  const Scene scene;
  for (const int label : {1, 2}) {
    const RegionSamples& region = scene.memory.regions[label];
    const SurfaceSamples& samples = region.samples;
    const std::vector<int> pixels = scene.pixelsOf(label);
    ASSERT_EQ(samples.size, (pixels.size() + 3) / 4 * 4);
    double squares = 0.0;
    for (const int i : pixels) {
      squares += std::pow(region.plane.signedDistance(scene.grid.point(i).cast<double>()), 2);
    }
    const double rms = std::sqrt(squares / static_cast<double>(pixels.size()));
    EXPECT_LT(rms, 0.012);
    int used = 0;
    for (std::size_t k = 0; k < samples.size; ++k) {
      if (k >= pixels.size()) {
        EXPECT_EQ(samples.weight[k], 0.0F);
        continue;
      }
      const Eigen::Vector3d point = scene.grid.point(pixels[k]).cast<double>();
      const Eigen::Vector3d found = samples.center + Eigen::Vector3d(samples.x[k], samples.y[k], samples.z[k]);
      const Eigen::Vector3d beam = scene.grid.direction(pixels[k]).cast<double>();
      const double cosine = -region.plane.normal.dot(beam), distance = region.plane.signedDistance(point);
      EXPECT_LT((found - (point + distance / cosine * beam)).norm(), 1e-5);  // where the beam meets the plane
      EXPECT_NEAR(samples.height[k], distance, 1e-5);
      const double sigma = kNoise.sigma(scene.grid.range[pixels[k]]) * std::max(0.1, cosine);
      const double limit = 4.0 * std::max(sigma, rms), height = std::abs(double{samples.height[k]});
      if (std::abs(height - limit) < 1e-5) continue;
      EXPECT_NEAR(samples.weight[k], height < limit ? region.stride / (sigma * sigma) : 0.0,
                  1e-3 * region.stride / (sigma * sigma));
      used += height < limit ? 1 : 0;
    }
    EXPECT_NEAR(samples.used, used, 1);
    EXPECT_GT(used, 1000);
  }
}

}  // namespace
}  // namespace ppc
