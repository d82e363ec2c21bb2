// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_snapping.h"

#include "patch_plane_clustering/core/region_polygons.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "polygon_test_tools.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <random>

namespace ppc {
namespace {

using namespace testing_tools;

// Two walls that meet in an upright edge 3 m ahead, at `angle` from each other, seen up to 1.2 m above and below.
struct Edge {
  BeamGrid grid = forwardBeams(120, 160, 0.5 * kDegree);
  LabelImage labels;
  std::vector<PlanarRegion> regions;
  std::vector<PlanarPolygon> plain, snapped;
};

std::vector<Face> walls(double angle) {
  const double turn = 0.5 * (M_PI - angle);
  const Eigen::Vector3d point(3.0, 0.0, 0.0);
  const auto face = [&](double side) {
    const Eigen::Vector3d normal(-std::cos(turn), side * std::sin(turn), 0.0);
    return Face{{normal, normal.dot(point)},
                [side](const Eigen::Vector3d& p) { return side * p.y() <= 0.0 && std::abs(p.z()) < 1.2 && p.norm() < 4.0; }};
  };
  return {face(1.0), face(-1.0)};
}

// Labels as noise leaves them: the border strays by up to `stray` pixels.
void strayBorder(int stray, const BeamGrid& grid, LabelImage& labels) {
  std::mt19937 random(11);
  for (int r = 0; r < grid.rows; ++r) {
    int border = 1;
    while (border < grid.cols && labels.labels[grid.index(r, border)] == labels.labels[grid.index(r, border - 1)]) ++border;
    for (; border < grid.cols; ++border) {
      const std::int32_t left = labels.labels[grid.index(r, border - 1)], right = labels.labels[grid.index(r, border)];
      if (left > 0 && right > 0 && left != right) break;
    }
    if (border >= grid.cols) continue;
    const std::int32_t left = labels.labels[grid.index(r, border - 1)], right = labels.labels[grid.index(r, border)];
    const int moved = border - stray + static_cast<int>(random() % (2 * stray + 1));
    for (int c = border - stray; c < border + stray; ++c) labels.labels[grid.index(r, c)] = c < moved ? left : right;
  }
}

Edge makeEdge(double angle, double noise, int stray) {
  Edge edge;
  edge.labels = scanFaces(walls(angle), edge.grid);
  addNoise(edge.grid, noise);
  edge.regions = describeRegions(edge.grid, edge.labels);
  if (stray > 0) strayBorder(stray, edge.grid, edge.labels);
  PolygonOptions options;
  options.snap_creases = false;
  edge.plain = extractPolygons(edge.grid, edge.labels, edge.regions, options);
  options.snap_creases = true;
  edge.snapped = extractPolygons(edge.grid, edge.labels, edge.regions, options);
  return edge;
}

// Vertices of a polygon within `reach` of the true edge.
std::vector<Eigen::Vector3d> verticesAt(const PlanarPolygon& polygon, double reach) {
  std::vector<Eigen::Vector3d> found;
  for (const auto& p : polygon.outer) {
    if (std::hypot(p.x() - 3.0, p.y()) < reach) found.push_back(p);
  }
  return found;
}

TEST(CreaseSnapping, FacesMeetOnTheTrueEdge) {
  struct Case {
    double degrees, noise;
    int stray;
    double within;
  };
  for (const Case& c :
       {Case{90.0, 0.0, 1, 1e-4}, Case{90.0, 0.005, 1, 0.001}, Case{170.0, 0.0, 1, 1e-4}, Case{170.0, 0.005, 2, 0.005}}) {
    const Edge edge = makeEdge(c.degrees * kDegree, c.noise, c.stray);
    ASSERT_EQ(edge.regions.size(), 2U);
    ASSERT_EQ(edge.snapped.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(faultOf(edge.snapped[k], edge.regions[k].plane), "");
      const auto before = verticesAt(edge.plain[k], 0.15), after = verticesAt(edge.snapped[k], 0.15);
      EXPECT_GT(before.size(), 2U);  // the border strays
      ASSERT_EQ(after.size(), 2U) << c.degrees << " deg";
      EXPECT_GT(std::abs(after[0].z() - after[1].z()), 2.3);
      for (const auto& p : after)
        EXPECT_LT(std::hypot(p.x() - 3.0, p.y()), c.within) << c.degrees << " deg, " << p.transpose();
      EXPECT_LT(edge.snapped[k].outer.size(), edge.plain[k].outer.size());
    }
  }
}

TEST(CreaseSnapping, StrayingBordersDoNotChangeTheArea) {
  const Edge clean = makeEdge(90.0 * kDegree, 0.0, 0), stray = makeEdge(90.0 * kDegree, 0.0, 1);
  ASSERT_EQ(clean.snapped.size(), 2U);
  ASSERT_EQ(stray.snapped.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(stray.snapped[k].area, clean.snapped[k].area, 0.005 * clean.snapped[k].area);
}

void expectNothingMoves(const BeamGrid& grid, const LabelImage& labels) {
  const auto regions = describeRegions(grid, labels);
  const auto plain = extractPolygons(grid, labels, regions, {});
  auto snapped = plain;
  snapCreases(grid, labels, regions, 0.02, 1.0, snapped);
  ASSERT_EQ(snapped.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) EXPECT_EQ(snapped[i].outer, plain[i].outer);
}

TEST(CreaseSnapping, StepBetweenParallelWallsStays) {
  // Border of 20 cm in depth: no common line.
  BeamGrid grid = forwardBeams(80, 100, 0.5 * kDegree);
  const auto labels = scanFaces({{{-Eigen::Vector3d::UnitX(), -3.0}, [](const auto& p) { return p.y() > 0.0; }},
                                 {{-Eigen::Vector3d::UnitX(), -3.2}, [](const auto&) { return true; }}},
                                grid);
  expectNothingMoves(grid, labels);
}

TEST(CreaseSnapping, OccludingEdgeAwayFromTheLineStays) {
  // A shelf at z = -0.3 with its front edge at x = 2 before a wall at x = 3: the wall shows below the edge, 1 m behind it.
  BeamGrid grid = forwardBeams(80, 100, 0.5 * kDegree);
  const auto labels =
      scanFaces({{{Eigen::Vector3d::UnitZ(), -0.2}, [](const auto& p) { return p.x() > 1.5 && p.x() < 2.0; }},
                 {{-Eigen::Vector3d::UnitX(), -3.0}, [](const auto&) { return true; }}},
                grid);
  expectNothingMoves(grid, labels);
}

TEST(CreaseSnapping, CornerOfThreePlanesIsOnePoint) {
  BeamGrid grid = forwardBeams(120, 120, 0.5 * kDegree);
  for (int i = 0; i < grid.size(); ++i) {  // look into the corner
    const Eigen::Vector3f turned = Eigen::AngleAxisf(0.6F, Eigen::Vector3f(0.0F, 1.0F, 0.0F)) * grid.direction(i);
    grid.dir_x[i] = turned.x();
    grid.dir_y[i] = turned.y();
    grid.dir_z[i] = turned.z();
  }
  const Eigen::Vector3d corner(2.0, 0.0, -1.4);
  const Eigen::Vector3d left = Eigen::Vector3d(-1.0, -1.0, 0.0).normalized(), right(left.x(), -left.y(), 0.0);
  const auto everywhere = [](const Eigen::Vector3d& p) { return p.norm() < 4.0; };
  LabelImage labels = scanFaces({{{left, left.dot(corner)}, everywhere},
                                 {{right, right.dot(corner)}, everywhere},
                                 {{Eigen::Vector3d::UnitZ(), corner.z()}, everywhere}},
                                grid);
  addNoise(grid, 0.003);
  const auto regions = describeRegions(grid, labels);
  PolygonOptions options;
  options.snap_creases = true;
  const auto polygons = extractPolygons(grid, labels, regions, options);
  ASSERT_EQ(polygons.size(), 3U);
  std::vector<Eigen::Vector3d> corners;
  for (const auto& polygon : polygons) {
    EXPECT_EQ(faultOf(polygon, regions[polygon.id - 1].plane), "");
    const auto nearest = std::min_element(polygon.outer.begin(), polygon.outer.end(), [&](const auto& a, const auto& b) {
      return (a - corner).norm() < (b - corner).norm();
    });
    corners.push_back(*nearest);
    EXPECT_LT((*nearest - corner).norm(), 0.002);
  }
  EXPECT_LT((corners[0] - corners[1]).norm(), 1e-6);
  EXPECT_LT((corners[0] - corners[2]).norm(), 1e-6);
}

// Whatever the angle, the noise and the labels.
TEST(CreaseSnapping, EveryPolygonStaysValid) {
  Normal random(23);
  int changed = 0;
  for (int round = 0; round < 60; ++round) {
    BeamGrid grid = forwardBeams(60, 80, kDegree);
    LabelImage labels = scanFaces(walls((20.0 + 155.0 * random.uniform()) * kDegree), grid);
    addNoise(grid, 0.03 * random.uniform(), 0.0, 0.0, 100 + round);
    const auto regions = describeRegions(grid, labels);
    strayBorder(1 + round % 4, grid, labels);
    const double speckle = 0.1 * random.uniform() * (round % 2);
    for (std::int32_t& label : labels.labels) {
      if (random.uniform() < speckle) label = static_cast<std::int32_t>(3.0 * random.uniform());
    }
    PolygonOptions options;
    options.simplification_tolerance = round % 3 == 0 ? 0.0 : 0.02;
    const auto plain = extractPolygons(grid, labels, regions, options);
    options.snap_creases = true;
    const auto snapped = extractPolygons(grid, labels, regions, options);
    ASSERT_EQ(snapped.size(), plain.size());
    for (std::size_t i = 0; i < snapped.size(); ++i) {
      EXPECT_EQ(faultOf(snapped[i], regions[snapped[i].id - 1].plane), "") << "round " << round;
      changed += snapped[i].outer != plain[i].outer ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 60);
}

}  // namespace
}  // namespace ppc
