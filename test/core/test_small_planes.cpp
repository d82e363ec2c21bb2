// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/small_planes.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kSmallest = 100;
const NoiseModel kNoise(SensorModel{0.01, 0.01, 100.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};

// A wall and a narrow panel before it, 5 columns wide; planes of both turned by some degrees.
struct Scene {
  BeamGrid grid = forwardBeams(90, 100, 0.01);
  LabelImage labels;
  std::vector<Plane> truth{{}, {-Eigen::Vector3d::UnitX(), -2.5}, {Eigen::Vector3d(-1.0, 0.5, 0.2).normalized(), -2.0}};
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::Zero(), {-0.3, 0.1, 0.0}, {-0.4, 0.1, 0.1}, {1.0, 2.0, 3.0}};
  SmallPlaneMemory memory;

  Scene() {
    labels = scan({wall(truth[1].normal, truth[1].d)}, grid);
    BeamGrid panel = grid;
    scan({wall(truth[2].normal, truth[2].d)}, panel);
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 40; c < 45; ++c) {
        grid.range[grid.index(r, c)] = panel.range[grid.index(r, c)];
        labels.labels[grid.index(r, c)] = 2;
      }
    }
    addNoise(grid, 0.01);
  }
  std::vector<std::int32_t> whole{0, 1, 2, 3, 4};
  bool found_strays = false;
  LabelImage left;  // labels after it

  std::vector<Eigen::Vector3d> refit(int threads = 1) {
    std::vector<Eigen::Vector3d> result = planes;
    left = labels;
    found_strays = refitSmallPlanes({grid, Eigen::Vector3d::Zero(), kNoise, kTolerance, kSmallest}, labelRuns(labels), whole,
                                    memory, result, left, threads);
    return result;
  }
};

TEST(RefitSmallPlanes, FitsThemToTheirPoints) {
  Scene scene;
  const std::vector<Eigen::Vector3d> result = scene.refit();
  const Eigen::Vector3d truth = scene.truth[2].normal / scene.truth[2].d;
  EXPECT_LT(std::acos(result[2].normalized().dot(truth.normalized())) / kDegree, 2.0);
  EXPECT_NEAR(truth.norm(), result[2].norm(), 0.01);
}

TEST(RefitSmallPlanes, LeavesTheOthers) {
  Scene scene;
  for (int i = 0; i < 90; ++i) scene.labels.labels[i] = 3;  // too few
  const std::vector<Eigen::Vector3d> result = scene.refit();
  EXPECT_EQ(scene.planes[1], result[1]);  // 8500 points
  EXPECT_EQ(scene.planes[3], result[3]);
  EXPECT_NE(scene.planes[2], result[2]);
}

TEST(RefitSmallPlanes, LeavesWhatHasNoPlane) {
  Scene scene;
  for (int i = 0; i < scene.grid.size(); ++i) {
    if (scene.labels.labels[i] == 2) scene.grid.range[i] += (i + i / 100) % 2 == 0 ? 0.5F : -0.5F;
  }
  EXPECT_EQ(scene.planes[2], scene.refit()[2]);
}

TEST(RefitSmallPlanes, TakesStraysOff) {
  Scene scene;
  scene.refit();
  EXPECT_FALSE(scene.found_strays);
  EXPECT_EQ(scene.left.labels, scene.labels.labels);
  const int strays[] = {scene.grid.index(20, 41), scene.grid.index(20, 42), scene.grid.index(21, 41)};
  for (const int i : strays) scene.grid.range[i] += 0.3F;
  scene.grid.range[scene.grid.index(50, 10)] -= 0.5F;  // of the wall, which is large
  scene.refit();
  EXPECT_TRUE(scene.found_strays);
  LabelImage expected = scene.labels;
  for (const int i : strays) expected.labels[i] = 0;
  EXPECT_EQ(scene.left.labels, expected.labels);
}

TEST(RefitSmallPlanes, LeavesRegionsOfWhichMuchStrays) {
  Scene scene;
  for (int r = 0; r < 90; r += 3) scene.grid.range[scene.grid.index(r, 42)] += 0.5F;  // 30 of 450
  scene.refit();
  EXPECT_FALSE(scene.found_strays);
  EXPECT_EQ(scene.left.labels, scene.labels.labels);
}

TEST(RefitSmallPlanes, WantsHalfOfThePointsNear) {
  Scene scene;
  for (int r = 0; r < 90; ++r) {
    for (int c = 40; c < 45; ++c)
      scene.grid.range[scene.grid.index(r, c)] += 0.02F * static_cast<float>((7 * r + 13 * c) % 50);
  }
  EXPECT_EQ(scene.planes[2], scene.refit()[2]);
  EXPECT_FALSE(scene.found_strays);
}

TEST(RefitSmallPlanes, LeavesToPiecesThePlaneOfTheirLabel) {
  Scene scene;
  scene.whole = {0, 1, 1, 3, 4};  // the panel is a piece of the wall's label
  EXPECT_EQ(scene.planes, scene.refit());
  scene.whole = {0, 1, 2, 3, 4};
  EXPECT_NE(scene.planes, scene.refit());
}

TEST(RefitSmallPlanes, DoesNotDependOnThreadsOrMemory) {
  Scene scene;
  for (int r = 0; r < 90; ++r) {  // three more regions, of the wall
    for (int c = 0; c < 30; ++c) scene.labels.labels[scene.grid.index(r, c)] = 3 + c / 10;
  }
  scene.planes.resize(6, Eigen::Vector3d(1.0, 2.0, 3.0));
  scene.whole.push_back(5);
  for (const int c : {5, 15, 25, 42}) scene.grid.range[scene.grid.index(40, c)] += 0.5F;
  const std::vector<Eigen::Vector3d> result = scene.refit();
  const LabelImage left = scene.left;
  EXPECT_TRUE(scene.found_strays);
  for (const int c : {5, 15, 25, 42}) EXPECT_EQ(left.labels[scene.grid.index(40, c)], 0);
  for (const int threads : {1, 2, 4}) {
    EXPECT_EQ(result, scene.refit(threads));
    EXPECT_EQ(left.labels, scene.left.labels);
  }
}

}  // namespace
}  // namespace ppc
