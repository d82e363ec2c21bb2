// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_merging.h"

#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"
#include "run_checks.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};

struct Scene {
  BeamGrid grid;
  NoiseModel noise;
  LabelImage labels;
  PatchGrid cells;
  CellShares shares;

  // Labels as measured, or, given `cut`, 1 left and 2 right of that column.
  explicit Scene(const std::vector<Surface>& surfaces, int cut = -1, const BeamGrid& beams = forwardBeams(60, 80, 0.005),
                 double sigma = 0.01)
      : grid(beams), noise(SensorModel{sigma, sigma, 10.0, 0.0}, 1.0) {
    labels = scan(surfaces, grid);
    addNoise(grid, sigma);
    if (cut >= 0) {
      for (int i = 0; i < grid.size(); ++i) labels.labels[i] = i % grid.cols < cut ? 1 : 2;
    }
    cells = makePatchGrid(grid, 4, true);
    weighPatches(noise, cells);
    shares = shareCells(grid, cells, noise, labels);
  }

  std::vector<Eigen::Vector3d> planes;

  void merge() {
    MergeMemory memory;
    std::vector<LabelRun> runs;
    mergeLabels(cells, noise, kTolerance, 0.1, memory, shares, labels, runs, planes);
    expectRunsOf(labels, runs);
  }
};

const auto kLeft = [](const Eigen::Vector3d& p) { return p.y() > 0.0; };
const Surface kWall = wall({-1.0, 0.0, 0.0}, -3.0);

TEST(MergeLabels, JoinsTheHalvesOfAWall) {
  Scene scene({kWall}, 42);
  scene.merge();
  EXPECT_EQ(countOf(scene.labels, scene.labels.labels[0]), scene.grid.size());
  const auto planes = labelPlanes(scene.shares);
  ASSERT_GE(scene.planes.size(), planes.size());
  for (std::size_t label = 1; label < planes.size(); ++label) EXPECT_LT((scene.planes[label] - planes[label]).norm(), 1e-9);
  EXPECT_EQ(scene.shares.sums[scene.labels.labels[0]].n, scene.grid.size());
  // The shares of the cells that were cut are added up.
  EXPECT_EQ(scene.shares.labels, std::vector<std::int32_t>(scene.cells.patches.size(), scene.labels.labels[0]));
}

TEST(MergeLabels, KeepsAStepAndACrease) {
  for (const auto& surfaces : std::vector<std::vector<Surface>>{
           {surfaceOf({{-Eigen::Vector3d::UnitX(), -2.95}, kLeft}), kWall},
           {surfaceOf({{Eigen::Vector3d(-1.0, 0.3, 0.0).normalized(), -3.0 / std::sqrt(1.09)}, kLeft}), kWall}}) {
    Scene scene(surfaces);
    const std::vector<std::int32_t> before = scene.labels.labels;
    scene.merge();
    EXPECT_EQ(scene.labels.labels, before);
  }
}

// A box from above, its top seen obliquely and just two lines of its front. The best plane for both is nearly that of the
// top, where the tolerance along the beams is large.
TEST(MergeLabels, KeepsASmallFrontApartFromATopSeenObliquelyUnlessErrorsAreCorrelated) {
  constexpr double kStep = 0.006, kFront = 2.0, kSigma = 0.02;
  const double tilt = 0.2, height = kFront * std::tan(tilt - 0.5 * kStep);
  BeamGrid grid = toBeamGrid(noddingScan(14, 60, tilt - 12 * kStep, tilt + kStep, 30 * kStep));
  const LabelImage faces =
      scan({surfaceOf({{Eigen::Vector3d::UnitZ(), -height}, [=](const Eigen::Vector3d& p) { return p.x() > kFront; }}),
            surfaceOf({{-Eigen::Vector3d::UnitX(), -kFront}, [=](const Eigen::Vector3d& p) { return p.z() < -height; }})},
           grid);
  ASSERT_EQ(countOf(faces, 2), 120);
  addNoise(grid, kSigma);
  const NoiseModel noise(SensorModel{kSigma, kSigma, 10.0, 0.0}, 1.0);
  PatchGrid cells = makePatchGrid(grid, 4, true);
  weighPatches(noise, cells);
  for (const double inflation : {1.0, 1.3}) {
    LabelImage labels = faces;
    CellShares shares = shareCells(grid, cells, noise, labels);
    MergeMemory memory;
    std::vector<LabelRun> runs;
    std::vector<Eigen::Vector3d> planes;
    mergeLabels(cells, noise, {0.005, 0.005, inflation}, 0.1, memory, shares, labels, runs, planes);
    EXPECT_EQ(countOf(labels, 1), inflation == 1.0 ? 720 : 840);
  }
}

// Two walls that meet in the middle of the image, turned against each other.
Scene turnedWalls(double angle) {
  const Eigen::Vector3d left(-std::cos(0.5 * angle), -std::sin(0.5 * angle), 0.0);
  const Eigen::Vector3d right(-std::cos(0.5 * angle), std::sin(0.5 * angle), 0.0);
  const double d = -20.0 * std::cos(0.5 * angle);
  return Scene({surfaceOf({{left, d}, kLeft}), wall(right, d)});
}

TEST(MergeLabels, JoinsTheHalvesOfASmoothSagButNotOfACreaseOfTheSameTurn) {
  Scene sagging({column(31.2, 0.0, 19.2)}, 42);  // from one half to the other its normal turns by 0.12 rad
  sagging.merge();
  EXPECT_EQ(countOf(sagging.labels, sagging.labels.labels[0]), sagging.grid.size());
  const Eigen::Vector3d left(-std::cos(0.06), 0.06, 0.0), right(-std::cos(0.06), -0.06, 0.0);
  Scene creased({surfaceOf({{left.normalized(), -12.0}, kLeft}), wall(right, -12.0)});
  const std::vector<std::int32_t> before = creased.labels.labels;
  creased.merge();
  EXPECT_EQ(creased.labels.labels, before);
}

// Faces of 10 cm, creased by 12 degrees or not, as a sensor of a millimetre sees them: within 5 mm of one plane.
TEST(MergeLabels, KeepsSmallFacesApartThatAreTurnedForCertain) {
  for (const double half : {0.0, 6.0 * kDegree}) {
    const Eigen::Vector3d left(-std::cos(half), -std::sin(half), 0.0), right(-std::cos(half), std::sin(half), 0.0);
    const double d = -std::cos(half);
    Scene scene({surfaceOf({{left, d}, kLeft}), wall(right, d)}, 20, forwardBeams(60, 40, 0.005), 0.001);
    scene.merge();
    EXPECT_EQ(scene.labels.labels.front() == scene.labels.labels.back(), half == 0.0);
  }
}

TEST(MergeLabels, JoinsTheSlightlyTurnedHalvesOfABowedWall) {
  Scene bowed = turnedWalls(2.5 * kDegree);  // each half is 4 m wide and leaves the joint plane by some centimetres
  bowed.merge();
  EXPECT_EQ(bowed.labels.labels.front(), bowed.labels.labels.back());
  EXPECT_EQ(countOf(bowed.labels, bowed.labels.labels[0]), bowed.grid.size());
  Scene creased = turnedWalls(6.0 * kDegree);
  const std::vector<std::int32_t> before = creased.labels.labels;
  creased.merge();
  EXPECT_EQ(creased.labels.labels, before);
}

// A wall that bows with a radius of 30 m, seen 6 m wide, in two parts; with a step between them.
Scene wideBow(double step) {
  const Surface near = column(33.0, 0.0, 30.0), far = column(33.0 + step, 0.0, 30.0);
  const Surface wall = [=](const Eigen::Vector3d& o, const Eigen::Vector3d& u) {
    return (o + near(o, u) * u).y() > 1.9 ? far(o, u) : near(o, u);
  };
  return Scene({wall}, 136, forwardBeams(40, 160, 0.01));  // column 136 looks at y = 1.9 m
}

TEST(MergeLabels, JoinsThePartsOfAWideBowButNotAcrossAStep) {
  Scene bowed = wideBow(0.0);
  bowed.merge();
  EXPECT_EQ(countOf(bowed.labels, bowed.labels.labels[0]), bowed.grid.size());
  Scene stepped = wideBow(0.03);
  const std::vector<std::int32_t> before = stepped.labels.labels;
  stepped.merge();
  EXPECT_EQ(stepped.labels.labels, before);
}

TEST(MergeLabels, JoinsTheHalvesOfADome) {  // no plane fits its long border either
  Scene dome({ball({34.0, 0.0, 0.0}, 31.0)}, 70, forwardBeams(160, 140, 0.01));
  dome.merge();
  EXPECT_EQ(countOf(dome.labels, dome.labels.labels[0]), dome.grid.size());
}

TEST(MergeLabels, KeepsPiecesApartThatDoNotTouch) {
  Scene scene({kWall}, 40);
  for (int i = 0; i < scene.grid.size(); ++i) {
    if (std::abs(i % scene.grid.cols - 40) < 12) scene.labels.labels[i] = 0;
  }
  scene.shares = shareCells(scene.grid, scene.cells, scene.noise, scene.labels);
  scene.merge();
  EXPECT_EQ(scene.labels.labels.front(), 1);
  EXPECT_EQ(scene.labels.labels.back(), 2);
}

}  // namespace
}  // namespace ppc
