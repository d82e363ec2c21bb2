// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_trimming.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kNoise = 0.01;  // [m]
constexpr int kSmallest = 100;

// What surfaces show in an image of 60 x 100, all of it one region.
struct Scene {
  BeamGrid grid = forwardBeams(60, 100, 0.01);
  LabelImage truth, labels;
  NoiseModel noise{SensorModel{kNoise, kNoise, 10.0, 0.0}, 1.0};
  CoplanarityTolerance tolerance;

  explicit Scene(const std::vector<Surface>& surfaces) {
    truth = scan(surfaces, grid);
    addNoise(grid, kNoise);
    labels = truth;
    for (std::int32_t& label : labels.labels) label = label > 0 ? 1 : 0;
  }

  LabelImage trimmed(int threads = 1) const {
    TrimmingMemory memory;
    return trimmed(threads, memory);
  }
  LabelImage trimmed(int threads, TrimmingMemory& memory) const {
    LabelImage result = labels;
    const JudgedImage image{grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest};
    trimRegions(image, memory, result, threads);
    LabelImage again = labels;
    trimRegions(image, memory, again, threads);
    EXPECT_EQ(again.labels, result.labels);  // with memory as left
    return result;
  }

  // Share of a true face that still has a label.
  double keptOf(std::int32_t face, const LabelImage& result) const {
    int kept = 0;
    for (int i = 0; i < grid.size(); ++i) kept += truth.labels[i] == face && result.labels[i] != 0 ? 1 : 0;
    return static_cast<double>(kept) / countOf(truth, face);
  }
};

// Of a plane, what lies between two distances to the left, [m].
Surface between(const Plane& plane, double right, double left) {
  return surfaceOf({plane, [=](const Eigen::Vector3d& p) { return p.y() >= right && p.y() < left; }});
}
const Plane kWall{-Eigen::Vector3d::UnitX(), -2.0};

// A board before the sensor, eight columns wide, and its side, which leads away from it and shows as two columns or so.
Scene boardWithSide() {
  const Plane side{Eigen::Vector3d(-0.3, 1.0, 0.0).normalized(),
                   Eigen::Vector3d(-0.3, 1.0, 0.0).normalized().dot(Eigen::Vector3d(2.0, -0.3, 0.0))};
  return Scene({between(kWall, -0.46, -0.3), between(side, -0.3, -0.28)});
}

TEST(TrimRegions, TakesOffWhatLiesAlongABorder) {
  const Scene scene = boardWithSide();
  ASSERT_GT(countOf(scene.truth, 1), 400);
  ASSERT_GT(countOf(scene.truth, 2), 40);
  ASSERT_LT(countOf(scene.truth, 2), 0.25 * countOf(scene.truth, 1));
  const LabelImage result = scene.trimmed();
  EXPECT_GT(scene.keptOf(1, result), 0.9);
  EXPECT_LT(scene.keptOf(2, result), 0.5);
}

// A board and its side, a plane and a ball, each a region.
Scene threeRegions() {
  const Plane side{Eigen::Vector3d(-0.3, 1.0, 0.0).normalized(),
                   Eigen::Vector3d(-0.3, 1.0, 0.0).normalized().dot(Eigen::Vector3d(2.0, -0.3, 0.0))};
  Scene scene(
      {between(kWall, -0.46, -0.3), between(side, -0.3, -0.28), between(kWall, -0.1, 0.3), ball({2.0, 0.6, 0.0}, 0.18)});
  const std::int32_t regions[] = {0, 1, 1, 2, 3};
  for (int i = 0; i < scene.grid.size(); ++i) scene.labels.labels[i] = regions[scene.truth.labels[i]];
  return scene;
}

TEST(TrimRegions, JudgesRegionsOneByOneOnAnyThread) {
  const Scene scene = threeRegions();
  TrimmingMemory memory;
  const LabelImage result = scene.trimmed(1, memory);
  EXPECT_GT(scene.keptOf(1, result), 0.9);
  EXPECT_LT(scene.keptOf(2, result), 0.5);
  EXPECT_EQ(scene.keptOf(3, result), 1.0);
  EXPECT_EQ(scene.keptOf(4, result), 0.0);
  for (int threads = 2; threads <= 4; ++threads) EXPECT_EQ(scene.trimmed(threads).labels, result.labels);
  const LabelImage other = boardWithSide().trimmed(1, memory);  // with memory of another image
  EXPECT_EQ(other.labels, boardWithSide().trimmed().labels);
  EXPECT_EQ(scene.trimmed(2, memory).labels, result.labels);
}

TEST(TrimRegions, DropsWhatIsNoPlane) {
  const Scene scene({ball({2.0, 0.0, 0.0}, 0.18)});
  ASSERT_GT(countOf(scene.truth, 1), 200);
  const LabelImage result = scene.trimmed();
  EXPECT_EQ(countOf(result, 1), 0);
}

TEST(TrimRegions, LeavesPlanesAsTheyAre) {
  for (const Plane& plane : {kWall, Plane{Eigen::Vector3d(-1.0, 1.5, 0.4).normalized(), -1.2}}) {
    const Scene scene({between(plane, -0.3, 0.3)});
    ASSERT_GT(countOf(scene.truth, 1), 500);
    EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
  }
}

TEST(TrimRegions, LeavesPlanesWhoseNoiseIsLargerThanKnown) {
  Scene scene({between(kWall, -0.6, 0.6)});
  scene.tolerance.sigma_distance = 0.002;
  scene.tolerance.sigma_angle = 0.0;
  scene.noise = NoiseModel(SensorModel{0.5 * kNoise, 0.5 * kNoise, 10.0, 0.0}, 1.0);
  ASSERT_GT(countOf(scene.truth, 1), 2000);
  EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
}

TEST(TrimRegions, LeavesWhatItCannotJudge) {
  Scene correlated = boardWithSide();
  correlated.tolerance.inflation = 2.0;
  EXPECT_EQ(correlated.trimmed().labels, correlated.labels.labels);
  const Scene large({ball({2.0, 0.0, 0.0}, 0.9)});
  ASSERT_GT(countOf(large.truth, 1), 4000);
  EXPECT_EQ(large.trimmed().labels, large.labels.labels);
  Scene small = boardWithSide();
  for (int i = 0; i < small.grid.size(); ++i) {
    if (i / small.grid.cols >= 8) small.labels.labels[i] = 0;
  }
  ASSERT_LT(countOf(small.labels, 1), kSmallest);
  EXPECT_EQ(small.trimmed().labels, small.labels.labels);
}

// A column 2 m away, of which 60 of 100 columns are one region.
Scene bowedStrip(double radius) {
  Scene scene({column(2.0 + radius, 0.0, radius)});
  for (int i = 0; i < scene.grid.size(); ++i) {
    if (i % scene.grid.cols < 20 || i % scene.grid.cols >= 80) scene.labels.labels[i] = 0;
  }
  return scene;
}

TEST(TrimRegions, LeavesWhatASensorsOwnErrorsMayBend) {
  Scene scene = bowedStrip(6.0);  // sags by 3 cm
  ASSERT_LE(countOf(scene.labels, 1), 4000);
  EXPECT_EQ(scene.trimmed().labels, scene.labels.labels);
  scene.tolerance.sigma_angle = 0.0;
  EXPECT_EQ(countOf(scene.trimmed(), 1), 0);
}

TEST(TrimRegions, TakesThreePixelsAtMostOffABowThatIsTolerated) {
  for (double radius = 7.0; radius <= 12.0; radius += 0.1) {
    const Scene scene = bowedStrip(radius);
    const LabelImage result = scene.trimmed();
    for (int i = 0; i < scene.grid.size(); ++i) {
      const int c = i % scene.grid.cols, r = i / scene.grid.cols;
      if (c < 23 || c >= 77 || r < 3 || r >= scene.grid.rows - 3) continue;
      ASSERT_EQ(result.labels[i], 1) << radius << ", row " << r << ", column " << c;
    }
  }
}

TEST(TrimRegions, ToleratesLessOfAFineSensor) {
  Scene scene = bowedStrip(1.6);  // sags by 13 cm, of which a tenth is left, and a tenth of the noise
  for (int i = 0; i < scene.grid.size(); ++i) {
    const double flat = 2.0 / scene.grid.direction(i).x();
    scene.grid.range[i] = static_cast<float>(flat + 0.1 * (scene.grid.range[i] - flat));
  }
  scene.noise = NoiseModel(SensorModel{0.1 * kNoise, 0.1 * kNoise, 10.0, 0.0}, 1.0);
  scene.tolerance.sigma_angle = 0.0;
  EXPECT_EQ(countOf(scene.trimmed(), 1), 0);
}

TEST(TrimRegions, DropsWhatIsNowhereNearItsPlane) {
  const auto quadrant = [](double distance, bool left, bool up) {
    return surfaceOf({{-Eigen::Vector3d::UnitX(), -distance},
                      [=](const Eigen::Vector3d& p) { return (p.y() > 0.0) == left && (p.z() > 0.0) == up; }});
  };
  const Scene scene(
      {quadrant(2.0, true, true), quadrant(3.0, true, false), quadrant(3.0, false, true), quadrant(2.0, false, false)});
  Scene middle = scene;
  for (int i = 0; i < middle.grid.size(); ++i) {
    if (i % middle.grid.cols < 20 || i % middle.grid.cols >= 80) middle.labels.labels[i] = 0;
  }
  ASSERT_LE(countOf(middle.labels, 1), 4000);
  EXPECT_EQ(countOf(middle.trimmed(), 1), 0);
}

}  // namespace
}  // namespace ppc
