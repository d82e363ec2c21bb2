// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/label_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

using namespace testing_tools;

const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);
constexpr double kMaxTurn = 0.35;

struct Scene {
  BeamGrid grid;
  LabelImage labels;

  explicit Scene(const std::vector<Surface>& surfaces, double noise = 0.01) : grid(forwardBeams(100, 200, 0.005)) {
    labels = scan(surfaces, grid);
    addNoise(grid, noise);
  }

  // Labels of a column of radius 1 at x = 4 by the angle around it, in strips of `width` rad; 0 beyond `half` rad.
  void stripsOfColumn(double width, double half) {
    for (int i = 0; i < grid.size(); ++i) {
      if (labels.labels[i] == 0) continue;
      const double angle = std::asin(std::clamp(double{grid.point(i).y()}, -1.0, 1.0));
      labels.labels[i] = std::abs(angle) < half ? 1 + static_cast<int>(std::floor((angle + half) / width)) : 0;
    }
  }

  void drop(double max_turn = kMaxTurn, const NoiseModel& noise = kNoise) {
    const std::vector<LabelRun> runs = labelRuns(labels);
    renameLabels(planarNames(grid, noise, kTolerance, max_turn, runs), runs, labels);
  }
};

// A wall 3 m ahead whose middle bulges towards the sensor by `bow` over 3 m, parabola in y.
Surface bowedWall(double bow) {
  return relief([bow](double y) { return 3.0 - bow * (1.0 - std::pow(y / 1.5, 2)); });
}

TEST(MeasureBends, APlaneHasNone) {
  const Scene scene({wall({-1.0, 0.2, 0.1}, -3.0)});
  const auto bends = measureBends(scene.grid, scene.labels, kNoise);
  ASSERT_EQ(bends.size(), 2U);
  EXPECT_LT(bends[1].turn, 0.02);
  EXPECT_LT(bends[1].amplitude, 0.001);
}

// White noise on a plane: the quadratic terms take their 3 degrees of freedom out of chi-square.
TEST(MeasureBends, TheExcessOfAPlaneIsChiSquareDistributed) {
  double mean = 0.0;
  for (int seed = 1; seed <= 100; ++seed) {
    BeamGrid grid = forwardBeams(30, 40, 0.005);  // few enough points that all of them are samples
    const LabelImage labels = scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
    addNoise(grid, 0.01, 0.0, 0.0, seed);
    mean += measureBends(grid, labels, kNoise)[1].excess / 100.0;
  }
  EXPECT_NEAR(mean, 3.0, 1.0);  // four standard deviations
}

// Noise that is not small against the surface, on beams that come in askew and fan out.
TEST(MeasureBends, APlaneHasNoneInMuchNoiseEither) {
  const NoiseModel noise(SensorModel{0.04, 0.04, 10.0, 0.0}, 1.0);
  double mean = 0.0;
  for (int seed = 1; seed <= 20; ++seed) {
    BeamGrid grid = forwardBeams(30, 40, 0.01);
    const LabelImage labels = scan({wall({-1.0, 1.0, 0.5}, -0.7)}, grid);
    addNoise(grid, 0.04, 0.0, 0.0, seed);
    mean += measureBends(grid, labels, noise)[1].excess / 20.0;
  }
  EXPECT_NEAR(mean, 3.0, 3.0);  // 19 if points are taken as measured
}

TEST(MeasureBends, TheTurnOfAStripOfAColumnIsItsAngle) {
  for (const double angle : {0.3, 0.6, 0.9}) {
    Scene scene({column(4.0, 0.0, 1.0)}, 0.0);
    scene.stripsOfColumn(angle, 0.5 * angle);
    const auto bends = measureBends(scene.grid, scene.labels, kNoise);
    ASSERT_EQ(bends.size(), 2U);
    EXPECT_NEAR(bends[1].turn, angle, 0.12 * angle);
    // Of a parabola of height h = w^2 / 8 R over its width, less its mean: h * 2 / (3 sqrt 5).
    const double height = 1.0 - std::cos(0.5 * angle);
    EXPECT_NEAR(bends[1].amplitude, height * 2.0 / (3.0 * std::sqrt(5.0)), 0.15 * height);
    EXPECT_GT(bends[1].excess, 0.0);
  }
}

TEST(DropCurvedRegions, ClearsAPieceOfAColumn) {
  Scene scene({column(4.0, 0.0, 1.0), wall({-1.0, 0.0, 0.0}, -8.0)});
  for (std::int32_t& label : scene.labels.labels) label = label == 1 ? 1 : 2;
  const int behind = countOf(scene.labels, 2);
  scene.drop();
  EXPECT_EQ(countOf(scene.labels, 1), 0);
  EXPECT_EQ(countOf(scene.labels, 2), behind);
}

TEST(DropCurvedRegions, ClearsStripsOfAFan) {
  Scene scene({column(4.0, 0.0, 1.0)}, 0.002);
  scene.stripsOfColumn(0.3, 0.6);  // each turns by less than the limit
  ASSERT_GT(countOf(scene.labels, 4), 100);
  scene.drop();
  EXPECT_EQ(countOf(scene.labels, 0), scene.grid.size());
}

// It turns by less than the limit, but its bend is far beyond noise and tolerance.
TEST(DropCurvedRegions, ClearsAStripThatBendsBeyondDoubt) {
  const NoiseModel coarse(SensorModel{0.04, 0.04, 10.0, 0.0}, 1.0);
  const auto pointsLeft = [&](double angle, double sigma, const NoiseModel& noise) {
    Scene scene({column(4.0, 0.0, 1.0)}, sigma);
    scene.stripsOfColumn(angle, 0.5 * angle);
    const int before = countOf(scene.labels, 1);
    scene.drop(0.45, noise);
    const int left = countOf(scene.labels, 1);
    EXPECT_TRUE(left == 0 || left == before);
    return left;
  };
  EXPECT_EQ(pointsLeft(0.4, 0.01, kNoise), 0);
  EXPECT_GT(pointsLeft(0.4, 0.04, coarse), 1000);  // noise makes it doubtful
  EXPECT_GT(pointsLeft(0.3, 0.01, kNoise), 1000);
  // Of a thin column, it is hardly as high as the tolerance.
  const NoiseModel fine(SensorModel{0.003, 0.003, 10.0, 0.0}, 1.0);
  Scene thin({column(3.5, 0.0, 0.5)}, 0.003);
  for (int i = 0; i < thin.grid.size(); ++i) {
    if (!(std::abs(thin.grid.point(i).y()) < 0.5F * std::sin(0.2F))) thin.labels.labels[i] = 0;
  }
  const int before = countOf(thin.labels, 1);
  ASSERT_GT(before, 500);
  thin.drop(0.45, fine);
  EXPECT_EQ(countOf(thin.labels, 1), before);
  // Smooth noise makes such bends.
  Scene scene({column(4.0, 0.0, 1.0)}, 0.01);
  scene.stripsOfColumn(0.4, 0.2);
  CoplanarityTolerance bumpy = kTolerance;
  bumpy.inflation_growth = 0.01;
  EXPECT_EQ(planarNames(scene.grid, kNoise, bumpy, 0.45, labelRuns(scene.labels)), (std::vector<std::int32_t>{0, 1}));
}

// Half a column, and a strip beside it that turns by a tenth of a radian, no part of one surface with it. In correlated
// noise a bend tells less than it seems to.
TEST(DropCurvedRegions, ClearsAStripThatHardlyTurnsBesideACurvedOne) {
  const NoiseModel fine(SensorModel{0.005, 0.005, 10.0, 0.0}, 1.0);
  const auto depth = [](double y) {
    return y < 0.0 ? 4.0 - std::sqrt(1.0 - std::min(1.0, y * y)) : 3.0 - 0.0055 * (1.0 - std::pow((y - 0.2) / 0.2, 2));
  };
  for (const bool white : {true, false}) {
    Scene scene({relief(depth)}, 0.005);
    for (int i = 0; i < scene.grid.size(); ++i) {
      const float y = scene.grid.point(i).y();
      scene.labels.labels[i] = y < -0.6F || y > 0.4F ? 0 : y < 0.0F ? 1 : 2;
    }
    CoplanarityTolerance tolerance = kTolerance;
    if (!white) tolerance.inflation_growth = 0.01;
    const std::vector<std::int32_t> names = planarNames(scene.grid, fine, tolerance, 0.45, labelRuns(scene.labels));
    EXPECT_EQ(names, (std::vector<std::int32_t>{0, 0, white ? 0 : 2})) << white;
  }
}

TEST(DropCurvedRegions, KeepsTheSidesOfAPostInMuchNoise) {
  const NoiseModel coarse(SensorModel{0.04, 0.04, 10.0, 0.0}, 1.0);
  for (const double half : {0.7, 1.0, 1.4}) {  // edges of 70, 90 and 109 deg
    Scene scene({wall({-1.0, half, 0.0}, -2.0), wall({-1.0, -half, 0.0}, -2.0)}, 0.04);
    for (int i = 0; i < scene.grid.size(); ++i) {
      if (std::abs(scene.grid.point(i).y()) > 0.2F) scene.labels.labels[i] = 0;
    }
    const std::vector<std::int32_t> before = scene.labels.labels;
    ASSERT_GT(countOf(scene.labels, 1), 1000);
    scene.drop(kMaxTurn, coarse);
    EXPECT_EQ(scene.labels.labels, before) << half;
  }
}

// A column is no parabola, and a fine sensor sees the difference; it is well below the tolerance.
TEST(DropCurvedRegions, ClearsStripsOfAFanAlsoForAFineSensor) {
  const NoiseModel fine(SensorModel{0.0005, 0.0005, 10.0, 0.0}, 1.0);
  Scene scene({column(4.0, 0.0, 1.0)}, 0.0005);
  scene.stripsOfColumn(0.3, 0.6);
  scene.drop(kMaxTurn, fine);
  EXPECT_EQ(countOf(scene.labels, 0), scene.grid.size());
}

TEST(DropCurvedRegions, KeepsPlanesThatMeetAtACrease) {
  for (const double half : {0.2, 0.5, 1.0}) {  // creases of 23, 53 and 90 deg
    Scene scene({wall({-1.0, half, 0.0}, -3.0), wall({-1.0, -half, 0.0}, -3.0)});
    const std::vector<std::int32_t> before = scene.labels.labels;
    scene.drop();
    EXPECT_EQ(scene.labels.labels, before) << half;
  }
}

// Faces of 7 cm: one quadratic surface leaves but a millimetre.
TEST(DropCurvedRegions, KeepsSmallFacesOfACreaseThatAFineSensorSees) {
  const NoiseModel fine(SensorModel{0.001, 0.001, 10.0, 0.0}, 1.0);
  Scene scene({wall({-1.0, 0.2, 0.0}, -0.15), wall({-1.0, -0.2, 0.0}, -0.15)}, 0.001);
  const std::vector<std::int32_t> before = scene.labels.labels;
  scene.drop(kMaxTurn, fine);
  EXPECT_EQ(scene.labels.labels, before);
}

// Faces of 7 cm, 34 deg apart: within the tolerance of one quadratic surface, and many points tell that they are two.
TEST(DropCurvedRegions, KeepsNarrowFacesOfACreaseSeenByManyBeams) {
  const NoiseModel noise(SensorModel{0.005, 0.005, 10.0, 0.0}, 1.0);
  Scene scene({wall({-1.0, 0.3, 0.0}, -0.8), wall({-1.0, -0.3, 0.0}, -0.8)}, 0.005);
  for (int i = 0; i < scene.grid.size(); ++i) {
    const float y = scene.grid.point(i).y();
    if (std::abs(y) > 0.07F) scene.labels.labels[i] = 0;
  }
  ASSERT_GT(std::min(countOf(scene.labels, 1), countOf(scene.labels, 2)), 1000);
  const std::vector<std::int32_t> before = scene.labels.labels;
  scene.drop(kMaxTurn, noise);
  EXPECT_EQ(scene.labels.labels, before);
}

// Faces of a prism, 2 cm wide and 45 deg apart: a fine sensor tells them from a cylinder by less.
TEST(DropCurvedRegions, KeepsFacesOfAPrismThatAFineSensorSees) {
  const double sigma = 0.0015;
  Scene scene({wall({-1.0, 0.41, 0.0}, -0.6), wall({-1.0, -0.41, 0.0}, -0.6)}, sigma);
  for (int i = 0; i < scene.grid.size(); ++i) {
    const Eigen::Vector3f point = scene.grid.point(i);
    if (std::abs(point.y()) > 0.018F || std::abs(point.z()) > 0.1F) scene.labels.labels[i] = 0;
  }
  const std::vector<std::int32_t> before = scene.labels.labels;
  scene.drop(kMaxTurn, NoiseModel(SensorModel{sigma, sigma, 10.0, 0.0}, 1.0));
  EXPECT_EQ(scene.labels.labels, before);
}

// Noise across strips at the limb is a fraction of that along the range: no reason to test them as a fine sensor's.
TEST(DropCurvedRegions, ClearsStripsOfAFanThatBeamsGraze) {
  const NoiseModel noise(SensorModel{0.003, 0.003, 10.0, 0.0}, 1.0);
  Scene scene({column(4.0, 0.0, 1.0)}, 0.003);
  scene.stripsOfColumn(0.3, 1.4);
  const std::int32_t last = *std::max_element(scene.labels.labels.begin(), scene.labels.labels.end());
  for (std::int32_t& label : scene.labels.labels) label = label >= last - 2 ? label : 0;
  ASSERT_LT(countOf(scene.labels, 0), scene.grid.size() - 1000);
  scene.drop(kMaxTurn, noise);
  EXPECT_GT(countOf(scene.labels, 0), scene.grid.size() - 10);
}

TEST(DropCurvedRegions, KeepsABowedWall) {
  Scene scene({bowedWall(0.02)});
  scene.drop();
  EXPECT_EQ(countOf(scene.labels, 1), scene.grid.size());
}

TEST(DropCurvedRegions, KeepsABowedWallFarBehindAColumn) {
  Scene scene({bowedWall(0.06), column(1.2, 0.0, 0.35)});
  const int of_wall = countOf(scene.labels, 1);
  ASSERT_LT(of_wall, 2 * countOf(scene.labels, 2));
  scene.drop();
  EXPECT_EQ(countOf(scene.labels, 1), of_wall);
  EXPECT_EQ(countOf(scene.labels, 2), 0);
}

// In pieces it bends as a fan of narrow strips does, but far wider.
TEST(DropCurvedRegions, KeepsThePiecesOfABowedWall) {
  const NoiseModel fine(SensorModel{0.0005, 0.0005, 10.0, 0.0}, 1.0);
  Scene scene({bowedWall(0.15)}, 0.0005);
  for (int i = 0; i < scene.grid.size(); ++i)
    scene.labels.labels[i] = 1 + static_cast<int>((scene.grid.point(i).y() + 3.0F));
  const std::vector<std::int32_t> before = scene.labels.labels;
  scene.drop(kMaxTurn, fine);
  EXPECT_EQ(scene.labels.labels, before);
}

// A bulge that hardly leaves a wall: its soft edge, as long as it is small beside it.
TEST(DropCurvedRegions, GivesABentStripToAMuchLargerPlaneThatItHardlyLeaves) {
  const NoiseModel fine(SensorModel{0.002, 0.002, 10.0, 0.0}, 1.0);
  for (const double half : {2.0, 0.25}) {
    Scene scene({wall({-1.0, 0.0, 0.0}, -3.0), column(3.285, 0.0, 0.3)}, 0.002);
    for (int i = 0; i < scene.grid.size(); ++i) {
      if (std::abs(scene.grid.point(i).y()) > half) scene.labels.labels[i] = 0;
    }
    const int flat = countOf(scene.labels, 1), bulge = countOf(scene.labels, 2);
    ASSERT_GT(bulge, 1000);
    ASSERT_GT(flat, bulge);
    scene.drop(kMaxTurn, fine);
    EXPECT_EQ(countOf(scene.labels, 2), 0);
    EXPECT_EQ(countOf(scene.labels, 1), flat > 4 * bulge ? flat + bulge : flat) << half;
  }
}

TEST(DropCurvedRegions, AWideLimitKeepsEverything) {
  Scene scene({column(4.0, 0.0, 1.0)});
  const int points = countOf(scene.labels, 1);
  ASSERT_GT(points, 1000);
  scene.drop(10.0);
  EXPECT_EQ(countOf(scene.labels, 1), points);
}

TEST(DropCurvedRegions, EmptyLabelsStayEmpty) {
  Scene scene({});
  scene.drop();
  EXPECT_EQ(countOf(scene.labels, 0), scene.grid.size());
  EXPECT_EQ(measureBends(scene.grid, scene.labels, kNoise).size(), 1U);
}

}  // namespace
}  // namespace ppc
