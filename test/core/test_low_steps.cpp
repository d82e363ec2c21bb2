// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/low_steps.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.04;  // [m]
constexpr int kSmallest = 100;

Plane planeOf(const Eigen::Vector3d& normal, double d) { return {normal.normalized(), d / normal.norm()}; }

// A wall three metres ahead, label 1, and a pane in it, label 2.
struct Scene {
  BeamGrid grid;
  LabelImage truth;
  std::vector<Eigen::Vector3d> planes;
  NoiseModel noise{SensorModel{kSigma, kSigma, 100.0, 0.0}, 1.0};
  CoplanarityTolerance tolerance;

  explicit Scene(const Plane& pane, BeamGrid beams = forwardBeams(80, 140, 0.005)) : grid(std::move(beams)) {
    const Plane wall = planeOf({-1.0, 0.0, 0.0}, -3.0);
    truth = scanPane(pane, grid);
    addNoise(grid, kSigma);
    planes = {Eigen::Vector3d::Zero(), wall.normal / wall.d, pane.normal / pane.d};
  }

  // As it is drawn where each pixel asks three columns and rows.
  LabelImage drawnByFew() const {
    LabelImage labels = truth;
    for (int r = 1; r + 1 < grid.rows; ++r) {
      for (int c = 1; c + 1 < grid.cols; ++c) {
        double evidence = 0.0;
        for (int k = 0; k < 9; ++k) {
          const int i = grid.index(r - 1 + k / 3, c - 1 + k % 3);
          const Eigen::Vector3d p = grid.point(i).cast<double>();
          evidence +=
              std::abs(planes[1].dot(p) - 1.0) / planes[1].norm() - std::abs(planes[2].dot(p) - 1.0) / planes[2].norm();
        }
        labels.labels[grid.index(r, c)] = evidence > 0.0 ? 2 : 1;
      }
    }
    // Far from the border, other windows had decided.
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 0; c < grid.cols; ++c) {
        if (!isNearBorder(r, c, 5)) labels.labels[grid.index(r, c)] = truth.labels[grid.index(r, c)];
      }
    }
    return labels;
  }
  bool isNearBorder(int row, int col, int reach) const {
    for (int r = std::max(0, row - reach); r <= std::min(grid.rows - 1, row + reach); ++r) {
      for (int c = std::max(0, col - reach); c <= std::min(grid.cols - 1, col + reach); ++c) {
        if (truth.labels[grid.index(r, c)] != truth.labels[grid.index(row, col)]) return true;
      }
    }
    return false;
  }

  struct Settled {
    LabelImage labels;
    std::vector<Eigen::Vector3d> planes;
    bool changed;
    std::size_t steps;
  };
  Settled settled(const LabelImage& labels, const std::vector<Eigen::Vector3d>& known, double rows_per_column = 1.0) const {
    LowStepMemory memory;
    Settled first = settled(labels, known, rows_per_column, memory);
    const Settled again = settled(labels, known, rows_per_column, memory);  // with memory as left
    EXPECT_EQ(first.labels.labels, again.labels.labels);
    EXPECT_EQ(first.planes, again.planes);
    return first;
  }
  Settled settled(const LabelImage& labels, const std::vector<Eigen::Vector3d>& known, double rows_per_column,
                  LowStepMemory& memory) const {
    Settled result{labels, known, false, 0};
    const std::vector<LabelRun> runs = labelRuns(labels);
    CreaseMeetings meetings;
    findCreaseMeetings(runs, labels.rows, labels.cols, planes.size(), kSmallest, meetings);
    const JudgedImage image{grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest};
    result.changed = settleLowSteps(image, meetings, runs, rows_per_column, memory, result.planes, result.labels);
    result.steps = memory.steps.size();
    EXPECT_EQ(result.changed, result.labels.labels != labels.labels);
    return result;
  }

  // Pixels that have another label than the one before them in their row or column.
  static int borderOf(const LabelImage& labels) {
    int count = 0;
    forEachChange(labels, [&](int, int, int) { ++count; });
    return count;
  }

  int wrong(const LabelImage& labels) const {
    int count = 0;
    for (int i = 0; i < grid.size(); ++i) count += labels.labels[i] != truth.labels[i] ? 1 : 0;
    return count;
  }
};

Scene paneBehind(double depth) { return Scene(planeOf({-1.0, 0.0, 0.0}, -3.0 - depth)); }

TEST(SettleLowSteps, DrawsTheBorderByManyPoints) {
  for (const double depth : {0.02, 0.03, -0.025}) {
    const Scene scene = paneBehind(depth);
    const LabelImage ragged = scene.drawnByFew();
    ASSERT_GT(scene.wrong(ragged), 300);
    const auto settled = scene.settled(ragged, scene.planes);
    EXPECT_LT(scene.wrong(settled.labels), 0.65 * scene.wrong(ragged)) << depth;
    EXPECT_LT(Scene::borderOf(settled.labels), 0.65 * Scene::borderOf(ragged)) << depth;
  }
}

// A strip of wall beside the pane that had gone to it, and had drawn its plane.
TEST(SettleLowSteps, GivesAStripBackAndMendsThePlane) {
  const Scene scene = paneBehind(0.03);
  LabelImage labels = scene.truth;
  int taken = 0;
  for (int r = 25; r < 55; ++r) {
    for (int c = 1; c < 140; ++c) {
      const int i = scene.grid.index(r, c);
      if (labels.labels[i - 1] != 2 || labels.labels[i] != 1) continue;
      for (int k = 0; k < 8; ++k) labels.labels[i + k] = 2;
      taken += 8;
      break;
    }
  }
  ASSERT_EQ(taken, 240);
  std::vector<Eigen::Vector3d> known = scene.planes;
  known[2] += Eigen::Vector3d(0.0, -0.002, 0.0);  // turned towards the strip
  const auto settled = scene.settled(labels, known);
  EXPECT_LT(scene.wrong(settled.labels), taken / 2);
  EXPECT_LT((settled.planes[2] - scene.planes[2]).norm(), 0.6 * (known[2] - scene.planes[2]).norm());
}

TEST(SettleLowSteps, LeavesOthersAsTheyAre) {
  // A step that few points tell, one that may be a bow of the wall, planes that are turned.
  for (const Scene& scene : {paneBehind(0.06), paneBehind(0.008), Scene(planeOf({-1.0, 0.0, 0.25}, -3.0))}) {
    const auto settled = scene.settled(scene.drawnByFew(), scene.planes);
    EXPECT_FALSE(settled.changed);
    EXPECT_EQ(settled.planes, scene.planes);
  }
  Scene correlated = paneBehind(0.03);
  correlated.tolerance.inflation = 2.0;
  EXPECT_FALSE(correlated.settled(correlated.drawnByFew(), correlated.planes).changed);
}

// Along the line where planes cross, nothing tells; what is there stays what it is.
TEST(SettleLowSteps, TakesNothingWherePlanesCross) {
  const Scene scene(planeOf({-1.0, 0.12, 0.0}, -3.0 - 0.024));  // crosses the wall in the middle of the pane
  const auto settled = scene.settled(scene.truth, scene.planes);
  ASSERT_EQ(settled.steps, 1U);
  EXPECT_LT(scene.wrong(settled.labels), 0.03 * countOf(scene.truth, 2));
}

// Lines four times as close as beams are.
TEST(SettleLowSteps, AsksWindowsOfEqualAngle) {
  const double step = 0.0025;
  const Scene scene(planeOf({-1.0, 0.0, 0.0}, -3.025),
                    toBeamGrid(noddingScan(160, 70, -80 * step, 79 * step, 0.5 * 69 * 4.0 * step)));
  const LabelImage ragged = scene.drawnByFew();
  const int right = scene.wrong(scene.settled(ragged, scene.planes, 4.0).labels);
  const int wrong = scene.wrong(scene.settled(ragged, scene.planes, 0.25).labels);
  EXPECT_LT(right, 0.85 * wrong);
}

}  // namespace
}  // namespace ppc
