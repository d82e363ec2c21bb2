// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_splitting.h"

#include "patch_plane_clustering/core/clustering.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kFine = 0.001;  // noise of a fine sensor [m]

// All that is measured as one label.
struct Scene {
  NoiseModel noise;
  BeamGrid grid;
  LabelImage truth, labels;
  PatchGrid cells;
  CellShares shares;

  // @param excess what the noise in the image is over the model's, `sigma`.
  explicit Scene(const std::vector<Surface>& surfaces, double step = 0.005, double sigma = 0.01, double excess = 1.0)
      : noise(SensorModel{sigma, sigma, 10.0, 0.0}, 1.0),
        grid(forwardBeams(static_cast<int>(0.2 / step), static_cast<int>(0.3 / step), step)) {
    truth = scan(surfaces, grid);
    addNoise(grid, excess * sigma);
    labels = truth;
    for (std::int32_t& label : labels.labels) label = label > 0 ? 1 : 0;
    sumCells();
  }

  void sumCells() {
    cells = makePatchGrid(grid, 4, true);
    weighPatches(noise, cells);
    shares = shareCells(grid, cells, noise, labels);
  }

  bool split(double inflation = 1.0, int smallest = 350, int threads = 1) {
    return split({0.005, 0.005, inflation}, smallest, false, threads);
  }

  // As kinect-like noise is: alike over some pixels, of as much as the model says.
  bool splitSmooth(bool merged) {
    addSmoothNoise(grid, noise.sigma(3.0), 1.5);
    sumCells();
    return split({0.005, 0.005, 3.0, 0.5, 20.0}, 350, merged, 1);
  }

  bool split(const CoplanarityTolerance& tolerance, int smallest, bool merged, int threads) {
    LabelSplitMemory memory;
    return splitLabels(grid, cells, noise, tolerance, smallest, merged, memory, shares, labels, threads);
  }

  int count() const { return static_cast<int>(shares.sums.size()) - 1; }

  // Points of a true face that have a label.
  int common(std::int32_t face, std::int32_t label) const {
    int n = 0;
    for (int i = 0; i < grid.size(); ++i) n += truth.labels[i] == face && labels.labels[i] == label ? 1 : 0;
    return n;
  }
};

const auto kLeft = [](const Eigen::Vector3d& p) { return p.y() > 0.2; };
const Surface kWall = wall({-1.0, 0.0, 0.0}, -3.0);
// The left end of the wall, turned.
Surface turned(double angle) {
  const Eigen::Vector3d normal(-std::cos(angle), std::sin(angle), 0.0);
  return surfaceOf({{normal, normal.dot(Eigen::Vector3d(3.0, 0.2, 0.0))}, kLeft});
}
const Surface kRest = surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, [](const Eigen::Vector3d& p) { return p.y() <= 0.2; }});

TEST(SplitLabels, GivesASwallowedFaceALabelOfItsOwn) {
  for (const Surface& face : {turned(0.4), turned(-0.3), surfaceOf({{-Eigen::Vector3d::UnitX(), -2.95}, kLeft})}) {
    Scene scene({face, kRest});
    EXPECT_TRUE(scene.split());
    ASSERT_EQ(scene.count(), 2);
    EXPECT_GT(scene.common(2, 1), 0.9 * countOf(scene.truth, 2));
    EXPECT_GT(scene.common(1, 2), 0.9 * countOf(scene.truth, 1));
  }
}

TEST(SplitLabels, BringsSharesUpToDate) {
  Scene scene({turned(0.4), kRest});
  scene.split();
  const CellShares anew = shareCells(scene.grid, scene.cells, scene.noise, scene.labels);
  EXPECT_EQ(scene.shares.labels, anew.labels);
  EXPECT_EQ(scene.shares.only, anew.only);
  ASSERT_EQ(scene.shares.sums.size(), anew.sums.size());
  for (std::size_t label = 1; label < anew.sums.size(); ++label) {
    EXPECT_EQ(scene.shares.sums[label].n, anew.sums[label].n);
    EXPECT_NEAR(scene.shares.sums[label].xx, anew.sums[label].xx, 1e-9 * anew.sums[label].xx);
  }
}

TEST(SplitLabels, LeavesPlanesAndCurvedSurfacesWhole) {
  const Surface sag = column(23.0, 0.0, 20.0);
  for (const Surface& surface :
       {kWall, wall({-1.0, 2.0, 0.5}, -3.0), column(4.0, 0.0, 1.0), sag, ball({4.0, 0.0, 0.0}, 1.5)}) {
    for (const double sigma : {0.01, kFine}) {
      Scene scene({surface}, 0.005, sigma);
      const std::vector<std::int32_t> before = scene.labels.labels;
      EXPECT_FALSE(scene.split());
      EXPECT_EQ(scene.count(), 1);
      EXPECT_EQ(scene.labels.labels, before);
    }
  }
}

TEST(SplitLabels, TellsLowStepsOfAFineSensorFromWaves) {
  const auto block = [](const Eigen::Vector3d& p) { return p.y() > -0.25 && p.y() < 0.1 && p.z() < 0.1; };
  const std::vector<Surface> faces = {
      surfaceOf({{-Eigen::Vector3d::UnitX(), -2.9975}, block}),
      surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, [&](const Eigen::Vector3d& p) { return !block(p); }})};
  Scene coarse(faces, 0.0025), fine(faces, 0.0025, kFine);
  EXPECT_FALSE(coarse.split());
  EXPECT_TRUE(fine.split());
  ASSERT_EQ(fine.count(), 2);
  EXPECT_GT(fine.common(2, 1), 0.95 * countOf(fine.truth, 2));
  EXPECT_GT(fine.common(1, 2), 0.9 * countOf(fine.truth, 1));
  Scene waves({relief([](double y) { return 3.0 - 0.00125 * std::sin(10.0 * y); })}, 0.0025, kFine);  // of as much in all
  waves.split();
  EXPECT_EQ(waves.count(), 1);
}

// Two faces that meet in the middle, each turned by about `angle`.
std::vector<Surface> crease(double angle) { return {wall({-1.0, angle, 0.0}, -3.0), wall({-1.0, -angle, 0.0}, -3.0)}; }

// Two labels, of which each face has one but for a share of its points.
void expectSidesApart(const Scene& scene, double share) {
  ASSERT_EQ(scene.count(), 2);
  const std::int32_t left = scene.truth.labels.front(), right = scene.truth.labels.back();
  ASSERT_NE(left, right);
  const std::int32_t label = scene.labels.labels.front();
  EXPECT_GT(scene.common(left, label), (1.0 - share) * countOf(scene.truth, left));
  EXPECT_LT(scene.common(right, label), share * countOf(scene.truth, right));
}

TEST(SplitLabels, TellsLowCreasesOfAFineSensorFromBows) {
  const std::vector<Surface> low = crease(0.05);  // 6 degrees
  Scene coarse(low, 0.0025), fine(low, 0.0025, kFine), bow({column(11.0, 0.0, 8.0)}, 0.0025, kFine);
  EXPECT_FALSE(coarse.split());
  EXPECT_FALSE(bow.split());  // by 6 degrees, too
  EXPECT_TRUE(fine.split());
  expectSidesApart(fine, 0.05);
}

// A ramp on a floor, say, which a merge has taken for one that sags.
TEST(SplitLabels, TellsCreasesOfLargeLabelsFromBows) {
  const auto wide = [](const std::vector<Surface>& surfaces) { return Scene(surfaces, 0.00125, 0.004); };
  Scene creased = wide(crease(0.1)), correlated = wide(crease(0.1));
  Scene bowed = wide({column(7.6, 0.0, 4.6)});  // by as much from end to end
  EXPECT_GT(creased.cells.patches.size(), 1900U);
  EXPECT_FALSE(bowed.split());
  EXPECT_FALSE(correlated.split(2.0));
  EXPECT_TRUE(creased.split());
  expectSidesApart(creased, 0.02);
}

TEST(SplitLabels, LeavesLargeLabelsWholeWhereCreasesAreNotBeyondDoubt) {
  const auto splits = [](const std::vector<Surface>& surfaces, double sigma, double step = 0.00125) {
    return Scene(surfaces, step, sigma).split();
  };
  EXPECT_TRUE(splits(crease(0.03), 0.0026, 0.0006));  // 3.4 degrees
  EXPECT_TRUE(splits(crease(0.03), 0.0024, 0.0006));  // nor does less noise hide it
  EXPECT_FALSE(splits(crease(0.015), 0.0026));
  EXPECT_FALSE(splits(crease(0.1), 0.02));  // noise leaves too much open
  // Bows that are not quadratic: of a wall that is flat at one end, and of one that bulges.
  EXPECT_FALSE(splits({relief([](double y) { return 3.0 - 0.1 * std::pow(std::max(0.0, y), 2); })}, 0.004));
  EXPECT_FALSE(splits({relief([](double y) { return 3.0 - 0.015 * std::sin(5.0 * y); })}, 0.004));
}

TEST(SplitLabels, TellsWhatAMergeHasJoinedWhereNoiseIsSmooth) {
  const auto wide = [](const std::vector<Surface>& surfaces) { return Scene(surfaces, 0.00125, 0.004, 0.0); };
  const auto split = [&](const std::vector<Surface>& surfaces) { return wide(surfaces).splitSmooth(true); };
  Scene creased = wide(crease(0.1)), before = wide(crease(0.1));
  EXPECT_GT(creased.cells.patches.size(), 1900U);
  EXPECT_FALSE(before.splitSmooth(false));
  EXPECT_TRUE(creased.splitSmooth(true));
  expectSidesApart(creased, 0.05);
  CoplanarityTolerance few{0.005, 0.005, 3.0};  // alike over few pixels
  for (const bool around : {false, true}) {
    Scene scene = wide(crease(0.1));
    addSmoothNoise(scene.grid, 0.004, 0.7);
    scene.sumCells();
    few.alike_around = around;
    EXPECT_EQ(scene.split(few, 350, true, 1), around);
  }
  const auto step = [](double depth) {
    return std::vector<Surface>{surfaceOf({{-Eigen::Vector3d::UnitX(), -depth}, kLeft}), kRest};
  };
  EXPECT_TRUE(split(step(2.96)));
  EXPECT_FALSE(split(step(2.99)));
  EXPECT_FALSE(split({kWall}));
  EXPECT_FALSE(split({column(7.6, 0.0, 4.6)}));  // bends by as much as the crease from end to end
  EXPECT_FALSE(split({relief([](double y) { return 3.0 - 0.015 * std::sin(5.0 * y); })}));
}

// Two faces that meet at 14 degrees as one label of many cells, which has some points of what is beside it.
TEST(SplitLabels, TellsACreaseAlthoughTheLabelHasPointsOfAThirdFace) {
  Scene scene(crease(0.12), 0.0025, kFine);
  EXPECT_GT(scene.cells.patches.size(), 400U);
  for (int col = 0; col < 12; ++col) scene.grid.range[scene.grid.index(0, col)] += 0.03F;
  scene.sumCells();
  EXPECT_TRUE(scene.split());
  const std::int32_t right = scene.truth.labels.back(), left = 3 - right, label = scene.labels.labels.back();
  EXPECT_GT(scene.common(right, label), 0.95 * countOf(scene.truth, right));
  EXPECT_LT(scene.common(left, label), 0.05 * countOf(scene.truth, left));
}

TEST(SplitLabels, LeavesAStepWithinTheToleranceWhole) {
  Scene scene({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.996}, kLeft}), kRest});
  scene.split();
  EXPECT_EQ(scene.count(), 1);
}

TEST(SplitLabels, SplitsSidesAgainButNotWhereErrorsAreCorrelated) {
  const auto between = [](double low, double high) {
    return [=](const Eigen::Vector3d& p) { return p.y() > low && p.y() <= high; };
  };
  const std::vector<Surface> steps = {surfaceOf({{-Eigen::Vector3d::UnitX(), -2.9}, between(-9.0, -0.15)}),
                                      surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, between(-0.15, 0.15)}),
                                      surfaceOf({{-Eigen::Vector3d::UnitX(), -2.95}, between(0.15, 9.0)})};
  Scene white(steps), shared(steps);
  white.split();
  EXPECT_EQ(white.count(), 3);
  shared.split(1.0, 350, 2);
  EXPECT_EQ(shared.labels.labels, white.labels.labels);
  Scene correlated(steps);
  correlated.split(2.0);
  EXPECT_EQ(correlated.count(), 1);
}

TEST(SplitLabels, GivesStripsOfTwoPlanesTwoLabels) {
  std::vector<Surface> strips;
  for (int k = 0; k < 5; ++k) {
    const auto inside = [k](const Eigen::Vector3d& p) { return std::floor((p.y() / p.x() + 0.15) / 0.06) == k; };
    strips.push_back(surfaceOf({{-Eigen::Vector3d::UnitX(), k % 2 == 0 ? -3.0 : -2.9}, inside}));
  }
  Scene scene(strips);
  scene.split();
  ASSERT_EQ(scene.count(), 2);
  for (int k = 1; k <= 5; ++k) {
    EXPECT_EQ(scene.common(k, scene.labels.labels[scene.grid.index(20, 12 * (5 - k) + 6)]), countOf(scene.truth, k));
  }
}

// Of as many cells as one wall has: a low step and a crease are found, and what bends is left to the test of curvature.
TEST(SplitLabels, SplitsLargeLabelsAtLowSteps) {
  Scene step({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.98}, kLeft}), kRest}, 0.0025);
  EXPECT_GT(step.cells.patches.size(), 400U);
  EXPECT_TRUE(step.split());
  ASSERT_EQ(step.count(), 2);
  EXPECT_GT(step.common(2, 1), 0.9 * countOf(step.truth, 2));
  EXPECT_GT(step.common(1, 2), 0.9 * countOf(step.truth, 1));
  Scene creased({turned(0.3), kRest}, 0.0025);
  EXPECT_TRUE(creased.split());
  ASSERT_EQ(creased.count(), 2);
  EXPECT_GT(creased.common(2, 1), 0.95 * countOf(creased.truth, 2));
  EXPECT_GT(creased.common(1, 2), 0.9 * countOf(creased.truth, 1));
  EXPECT_FALSE(Scene({column(3.0, 0.0, 0.3)}, 0.0025).split());
  EXPECT_FALSE(Scene({kWall}, 0.0025).split());
  EXPECT_FALSE(Scene({surfaceOf({{-Eigen::Vector3d::UnitX(), -2.98}, kLeft}), kRest}, 0.0025).split(4.0));
}

// No straight cut divides a door from its wall.
bool isDoor(const Eigen::Vector3d& p) { return std::abs(p.y() + 0.1) < 0.12 && p.z() < 0.12; }
Surface doorAt(double x) { return surfaceOf({{-Eigen::Vector3d::UnitX(), -x}, isDoor}); }
const Surface kAround = surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, [](const Eigen::Vector3d& p) { return !isDoor(p); }});

TEST(SplitLabels, FindsADoorInAWall) {
  for (const double depth : {0.02, -0.02}) {
    Scene scene({doorAt(3.0 + depth), kAround}, 0.0025), shared = scene, correlated = scene;
    EXPECT_TRUE(scene.split());
    ASSERT_GE(scene.count(), 2);
    ASSERT_LE(scene.count(), 3);  // cells on the border may have their own
    const bool swapped = scene.common(1, 2) < scene.common(1, 1);
    EXPECT_GT(scene.common(1, swapped ? 1 : 2), 0.85 * countOf(scene.truth, 1));
    EXPECT_GT(scene.common(2, swapped ? 2 : 1), 0.95 * countOf(scene.truth, 2));
    shared.split(1.0, 350, 2);
    EXPECT_EQ(shared.labels.labels, scene.labels.labels);
    EXPECT_FALSE(correlated.split(4.0));
  }
}

// Of 38 000 points, a noise that is 6 % more than the model's variance leaves more than any third plane would.
TEST(SplitLabels, FindsADoorWhereTheNoiseIsNotQuiteKnown) {
  Scene scene({doorAt(3.01), kAround}, 0.00125, 0.01, 1.03);
  EXPECT_TRUE(scene.split());
  EXPECT_FALSE(Scene({kWall}, 0.00125, 0.01, 1.03).split());
}

TEST(SplitLabels, LeavesAWallWhoseLinesAreOffWhole) {
  std::vector<Surface> lines;
  for (int k = -6; k < 6; ++k) {
    const auto inside = [k](const Eigen::Vector3d& p) { return std::floor(p.z() / p.x() / 0.02) == k; };
    lines.push_back(surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0 - 0.01 * ((k * k + 12) % 3)}, inside}));
  }
  EXPECT_FALSE(Scene(lines, 0.0025).split());
}

TEST(SplitLabels, LeavesSmallLabelsAlone) {
  Scene scene({turned(0.4), kRest});
  scene.split(1.0, 2401);
  EXPECT_EQ(scene.count(), 1);
}

}  // namespace
}  // namespace ppc
