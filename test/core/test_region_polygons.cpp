// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_polygons.h"

#include "patch_plane_clustering/core/region_statistics.h"
#include "polygon_test_tools.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

struct Result {
  std::vector<PlanarRegion> regions;
  std::vector<PlanarPolygon> polygons;
};

// Extracts, and holds every polygon to the promises of the header.
Result outline(const BeamGrid& grid, const LabelImage& labels, const PolygonOptions& options = {}) {
  Result result;
  result.regions = describeRegions(grid, labels);
  result.polygons = extractPolygons(grid, labels, result.regions, options);
  for (const PlanarPolygon& polygon : result.polygons) {
    for (const PlanarRegion& region : result.regions) {
      if (region.id == polygon.id) {
        EXPECT_EQ(faultOf(polygon, region.plane), "") << "id " << polygon.id;
      }
    }
  }
  return result;
}

const Plane kWall{-Eigen::Vector3d::UnitX(), -3.0};  // at x = 3

Face wallWith(std::function<bool(const Eigen::Vector3d&)> contains) { return {kWall, std::move(contains)}; }

BeamGrid forwardGrid() { return toBeamGrid(noddingScan(161, 241, -40 * kDegree, 40 * kDegree, 60 * kDegree)); }

double distanceToRing(const Eigen::Vector3d& p, const std::vector<Eigen::Vector3d>& ring) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector3d a = ring[i], edge = ring[(i + 1) % ring.size()] - a;
    const double along = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - along * edge).norm());
  }
  return nearest;
}

TEST(RegionPolygons, RectangleHasFourVerticesAndTheRightArea) {
  BeamGrid grid = forwardGrid();
  const auto labels =
      scanFaces({wallWith([](const auto& p) { return std::abs(p.y()) < 2.0 && std::abs(p.z() - 0.3) < 1.0; })}, grid);
  const auto polygons = outline(grid, labels).polygons;
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_EQ(polygons[0].id, 1);
  EXPECT_TRUE(polygons[0].holes.empty());
  EXPECT_NEAR(polygons[0].area, 8.0, 0.02 * 8.0);
  EXPECT_EQ(polygons[0].outer.size(), 4U);
  for (const auto& p : polygons[0].outer) {  // within a pixel, 2.6 to 4 cm, of the true corners
    EXPECT_NEAR(std::abs(p.y()), 2.0, 0.03);
    EXPECT_NEAR(std::abs(p.z() - 0.3), 1.0, 0.03);
  }
}

TEST(RegionPolygons, WindowIsAHole) {
  BeamGrid grid = forwardGrid();
  const auto labels = scanFaces({wallWith([](const auto& p) {
                                  const bool window = std::abs(p.y() - 0.5) < 0.6 && std::abs(p.z()) < 0.5;
                                  return std::abs(p.y()) < 2.0 && std::abs(p.z()) < 1.2 && !window;
                                })},
                                grid);
  const auto polygons = outline(grid, labels).polygons;  // faultOf() checks orientation and nesting
  ASSERT_EQ(polygons.size(), 1U);
  ASSERT_EQ(polygons[0].holes.size(), 1U);
  EXPECT_EQ(polygons[0].holes[0].size(), 4U);
  EXPECT_NEAR(polygons[0].area, 4.0 * 2.4 - 1.2, 0.02 * 8.4);
  for (const auto& p : polygons[0].holes[0]) EXPECT_NEAR(std::abs(p.y() - 0.5), 0.6, 0.03);
}

TEST(RegionPolygons, SmallHolesAreFilledAndSpecksLeftOut) {
  BeamGrid grid = forwardGrid();
  LabelImage labels =
      scanFaces({wallWith([](const auto& p) { return std::abs(p.y()) < 1.5 && std::abs(p.z()) < 1.0; })}, grid);
  const double area = outline(grid, labels).polygons[0].area;
  labels.labels[grid.index(80, 120)] = 0;
  labels.labels[grid.index(80, 121)] = 0;
  labels.labels[grid.index(5, 5)] = 1;  // detached
  PolygonOptions options;
  options.min_hole_size = 3;
  auto polygons = outline(grid, labels, options).polygons;
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_TRUE(polygons[0].holes.empty());
  EXPECT_NEAR(polygons[0].area, area, 1e-7);  // the plane of two points less
  options.min_hole_size = 1;
  polygons = outline(grid, labels, options).polygons;
  ASSERT_EQ(polygons.size(), 2U);
  EXPECT_EQ(polygons[0].holes.size(), 1U);
  EXPECT_GT(polygons[0].area, 100.0 * polygons[1].area);
}

TEST(RegionPolygons, SlantedEdgesLoseTheirStaircase) {
  BeamGrid grid = forwardGrid();
  const double slant = 17.0 * kDegree;
  const auto labels = scanFaces({wallWith([&](const auto& p) {
                                  const double u = std::cos(slant) * p.y() + std::sin(slant) * p.z();
                                  const double v = -std::sin(slant) * p.y() + std::cos(slant) * p.z();
                                  return std::abs(u) < 2.0 && std::abs(v) < 1.0;
                                })},
                                grid);
  const auto polygons = outline(grid, labels).polygons;
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_LE(polygons[0].outer.size(), 6U);
  EXPECT_NEAR(polygons[0].area, 8.0, 0.02 * 8.0);
  for (const auto& p : polygons[0].outer) {  // on the true outline within half a pixel
    const double u = std::abs(std::cos(slant) * p.y() + std::sin(slant) * p.z());
    const double v = std::abs(-std::sin(slant) * p.y() + std::cos(slant) * p.z());
    EXPECT_LT(std::max(std::abs(u - 2.0) * (v < 0.95 ? 1.0 : 0.0), std::abs(v - 1.0) * (u < 1.95 ? 1.0 : 0.0)), 0.02);
  }
}

TEST(RegionPolygons, OutlineStaysWithinTheTolerance) {
  BeamGrid grid = forwardGrid();
  const auto labels = scanFaces({wallWith([](const auto& p) {
                                  const double angle = std::atan2(p.z(), p.y());
                                  return std::hypot(p.y(), p.z()) < 1.0 + 0.3 * std::sin(7.0 * angle);
                                })},
                                grid);
  PolygonOptions options;
  options.simplification_tolerance = 0.0;
  const auto full = outline(grid, labels, options).polygons;
  ASSERT_EQ(full.size(), 1U);
  options.pixel_tolerance = 0.0;
  std::size_t before = full[0].outer.size();
  for (const double tolerance : {0.01, 0.03, 0.1}) {
    options.simplification_tolerance = tolerance;
    const auto simple = outline(grid, labels, options).polygons;
    ASSERT_EQ(simple.size(), 1U);
    EXPECT_LT(simple[0].outer.size(), before);
    before = simple[0].outer.size();
    for (const auto& p : full[0].outer) EXPECT_LE(distanceToRing(p, simple[0].outer), tolerance + 1e-9);
    for (std::size_t i = 0; i < before; ++i) {
      const Eigen::Vector3d a = simple[0].outer[i], b = simple[0].outer[(i + 1) % before];
      for (int k = 0; k < 10; ++k) EXPECT_LE(distanceToRing(a + 0.1 * k * (b - a), full[0].outer), tolerance + 1e-9);
    }
  }
  EXPECT_LT(before, 40U);
}

TEST(RegionPolygons, DiagonalTouchGivesTwoPolygonsApart) {
  BeamGrid grid = forwardGrid();
  LabelImage labels = scanFaces({wallWith([](const auto&) { return true; })}, grid);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const bool first = r >= 20 && r < 40 && c >= 30 && c < 60, second = r >= 40 && r < 70 && c >= 60 && c < 90;
      labels.labels[grid.index(r, c)] = first || second ? 1 : 0;
    }
  }
  const Result result = outline(grid, labels);
  ASSERT_EQ(result.polygons.size(), 2U);
  const Plane& plane = result.regions[0].plane;
  EXPECT_FALSE(bg::intersects(flatten(result.polygons[0], plane), flatten(result.polygons[1], plane)));
}

TEST(RegionPolygons, OnePixelWideLinesKeepTheirArea) {
  BeamGrid grid = forwardGrid();
  LabelImage labels = scanFaces({wallWith([](const auto&) { return true; })}, grid);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const bool comb = (r == 60 && c >= 40 && c < 200) || (c % 10 == 0 && r >= 60 && r < 120 && c >= 40 && c < 200);
      labels.labels[grid.index(r, c)] = comb ? 1 : 0;
    }
  }
  PolygonOptions exact;
  exact.simplification_tolerance = 0.0;
  const auto full = outline(grid, labels, exact).polygons;
  const auto simple = outline(grid, labels).polygons;
  ASSERT_EQ(full.size(), 1U);
  ASSERT_EQ(simple.size(), 1U);
  EXPECT_NEAR(simple[0].area, full[0].area, 0.04 * full[0].area);
  EXPECT_LT(simple[0].outer.size(), full[0].outer.size() / 4);
}

// A nodding scan with bearings beyond +-90 degrees: floor and ceiling in front and behind, and side walls on which all lines
// meet.
TEST(RegionPolygons, RoundThePoleAreasAgreeWithTheRoom) {
  for (const double lever : {0.0, 0.06}) {
    BeamGrid grid = toBeamGrid(noddingScan(241, 541, -60 * kDegree, 60 * kDegree, 135 * kDegree, {lever, 0.0, lever}));
    const auto everywhere = [](const Eigen::Vector3d& p) {
      return std::abs(p.x()) < 3.001 && std::abs(p.y()) < 2.001 && p.z() > -1.001 && p.z() < 1.501;
    };
    const auto labels = scanFaces({{{Eigen::Vector3d(0, 0, 1), -1.0}, everywhere},
                                   {{Eigen::Vector3d(0, 0, -1), -1.5}, everywhere},
                                   {{Eigen::Vector3d(-1, 0, 0), -3.0}, everywhere},
                                   {{Eigen::Vector3d(0, -1, 0), -2.0}, everywhere},
                                   {{Eigen::Vector3d(0, 1, 0), -2.0}, everywhere}},
                                  grid);
    const auto polygons = outline(grid, labels).polygons;
    for (const auto& p : polygons) {
      for (const auto& v : p.outer)
        EXPECT_TRUE(std::abs(v.x()) < 3.1 && std::abs(v.y()) < 2.1 && std::abs(v.z() - 0.25) < 1.35);
    }
    EXPECT_NEAR(totalArea(polygons, 3), 4.0 * 2.5, 0.02 * 10.0);
    if (lever > 0.0) continue;
    // Seen on the left wall: the wedge of +-60 degrees in front, cut at floor, ceiling and front wall, and the one behind,
    // within 135 degrees of bearing.
    const double tangent = std::tan(60.0 * kDegree);
    const double front = 2.5 * 3.0 - 0.5 * (1.5 * 1.5 + 1.0 * 1.0) / tangent;
    double floor = 4.0 * (3.0 - 1.0 / tangent);
    double behind = 0.0;  // the wall: x < 0, |x| <= 2 cos(tilt), |z| <= |x| tan(60), where x^2 + z^2 <= 2^2
    const int steps = 100000;
    for (int k = 0; k < steps; ++k) {
      const double z = -1.0 + 2.5 * (k + 0.5) / steps;
      behind += std::max(0.0, std::sqrt(4.0 - z * z) - std::abs(z) / tangent) * 2.5 / steps;
      const double x = 1.0 / tangent + (std::sqrt(3.0) - 1.0 / tangent) * (k + 0.5) / steps;  // floor: |y| >= hypot(x, z)
      floor += 2.0 * (2.0 - std::sqrt(x * x + 1.0)) * (std::sqrt(3.0) - 1.0 / tangent) / steps;
    }
    EXPECT_NEAR(totalArea(polygons, 1), floor, 0.02 * floor);
    EXPECT_NEAR(totalArea(polygons, 4), front + behind, 0.02 * (front + behind));
    EXPECT_NEAR(totalArea(polygons, 5), front + behind, 0.02 * (front + behind));
  }
}

// A short sweep of a scanner 8 cm off its axis over a face that it sees at 2 degrees, through the pole, with frayed ends.
TEST(RegionPolygons, FrayedRegionThroughThePoleIsTwoPieces) {
  RangeImage image = noddingScan(64, 121, -2.5 * kDegree, 2.5 * kDegree, 21 * kDegree, {0.0, 0.0, 0.08});
  image.bearing_min -= 90 * kDegree;
  BeamGrid grid = toBeamGrid(image);
  const Plane face{Eigen::Vector3d(0.0, 0.03, 1.0).normalized(), 0.0};
  LabelImage labels = scanFaces({{face, [](const auto&) { return true; }}}, grid);
  std::mt19937 random(3);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 1 + static_cast<int>(random() % 12); c-- > 0;) labels.labels[grid.index(r, c)] = 0;
    for (int c = static_cast<int>(random() % 12); c-- > 0;) labels.labels[grid.index(r, grid.cols - 1 - c)] = 0;
  }
  const double area = totalArea(outline(grid, labels).polygons, 1);
  constexpr int kRuns = 8;
  double noisy_area = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    BeamGrid noisy = grid;
    addNoise(noisy, 0.2, 0.0, 0.0, seed);
    const auto polygons = outline(noisy, labels).polygons;
    EXPECT_LE(polygons.size(), 3U) << seed;
    noisy_area += totalArea(polygons, 1) / kRuns;
  }
  EXPECT_NEAR(noisy_area, area, 0.1 * area);
}

TEST(RegionPolygons, FaceSeenEdgeOnIsTheHullOfItsPoints) {
  // Beams within a face, and noise: they meet its plane anywhere.
  BeamGrid grid = toBeamGrid(noddingScan(40, 60, -10 * kDegree, 10 * kDegree, 15 * kDegree));
  Normal normal(5);
  LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(grid.range.size(), 0)};
  for (int r = 18; r < 22; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      labels.labels[grid.index(r, c)] = 1;
      grid.range[grid.index(r, c)] = static_cast<float>(2.0 + 0.1 * normal.uniform());
    }
  }
  std::vector<PlanarRegion> regions(1);
  regions[0].id = 1;
  regions[0].plane = {Eigen::Vector3d(-0.002, 0.0, 1.0).normalized(), 0.0};
  regions[0].centroid = {2.0, 0.0, 0.004};
  const auto polygons = extractPolygons(grid, labels, regions, {});
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_EQ(faultOf(polygons[0], regions[0].plane), "");
  for (const auto& v : polygons[0].outer) EXPECT_TRUE(v.norm() > 1.9 && v.norm() < 2.11) << v.transpose();
  // A circular segment of 30 degrees: outer radius 2.1, its chord from the points at either end.
  EXPECT_NEAR(polygons[0].area, 0.5 * 2.1 * 2.1 * (30 * kDegree) - 0.5 * 2.0 * 2.0 * std::sin(30 * kDegree), 0.02);
}

TEST(RegionPolygons, FullTurnDoesNotTouchItselfAtTheSeam) {
  RangeImage image = noddingScan(40, 720, 20 * kDegree, 60 * kDegree, 0.0);
  image.bearing_increment = 0.5 * kDegree;
  for (int r = 0; r < image.rows; ++r) {  // a cone of beams, as of a spinning lidar: one row an elevation, looking down
    image.line_poses[r].setIdentity();
  }
  BeamGrid grid = toBeamGrid(image);
  for (int i = 0; i < grid.size(); ++i) {
    const double down = image.tilts[i / grid.cols], turn = image.bearing(i % grid.cols);
    grid.dir_x[i] = static_cast<float>(std::cos(down) * std::cos(turn));
    grid.dir_y[i] = static_cast<float>(std::cos(down) * std::sin(turn));
    grid.dir_z[i] = static_cast<float>(-std::sin(down));
  }
  const auto labels = scanFaces({{{Eigen::Vector3d::UnitZ(), -1.0}, [](const auto&) { return true; }}}, grid);
  const auto polygons = outline(grid, labels).polygons;
  ASSERT_GE(polygons.size(), 2U);
  const double step = 40.0 * kDegree / 39 / 2;  // half a row
  const double outer = 1.0 / std::tan(20 * kDegree - step), inner = 1.0 / std::tan(60 * kDegree + step);
  EXPECT_NEAR(totalArea(polygons, 1), M_PI * (outer * outer - inner * inner), 0.02 * M_PI * outer * outer);
}

TEST(RegionPolygons, GrazingBeamsStayFinite) {
  // The region's plane leaves the horizon in the middle of the region: half of its corners' beams miss it.
  BeamGrid grid = forwardGrid();
  LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(grid.range.size(), 1)};
  std::fill(grid.range.begin(), grid.range.end(), 2.0F);
  std::vector<PlanarRegion> regions(1);
  regions[0].id = 1;
  regions[0].plane = {Eigen::Vector3d::UnitZ(), -0.5};
  regions[0].centroid = {1.5, 0.0, -0.5};
  const auto polygons = extractPolygons(grid, labels, regions, {});
  ASSERT_FALSE(polygons.empty());
  for (const auto& polygon : polygons) {
    EXPECT_EQ(faultOf(polygon, regions[0].plane), "");
    for (const auto& v : polygon.outer) EXPECT_LT(v.norm(), 1.3 * 2.0);
  }
}

TEST(RegionPolygons, InvalidPixelsWithinARegionDoNoHarm) {
  BeamGrid grid = forwardGrid();
  const auto labels =
      scanFaces({wallWith([](const auto& p) { return std::abs(p.y()) < 2.0 && std::abs(p.z()) < 1.0; })}, grid);
  for (int i = 0; i < grid.size(); ++i) {
    if (i % 3 == 0 || (i / grid.cols) % 7 == 0) grid.range[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const auto polygons = outline(grid, labels).polygons;
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_NEAR(polygons[0].area, 8.0, 0.02 * 8.0);
}

TEST(RegionPolygons, WholeImageReachesHalfAStepBeyondTheOutermostBeams) {
  BeamGrid grid = toBeamGrid(noddingScan(21, 31, -10 * kDegree, 10 * kDegree, 15 * kDegree));
  const auto labels = scanFaces({wallWith([](const auto&) { return true; })}, grid);
  const auto polygons = outline(grid, labels).polygons;
  ASSERT_EQ(polygons.size(), 1U);
  double highest = 0.0;
  for (const auto& p : polygons[0].outer) highest = std::max(highest, p.z());
  EXPECT_NEAR(highest, 3.0 * std::tan(10.5 * kDegree), 0.001);
}

TEST(RegionPolygons, OneRowHasNoArea) {
  BeamGrid grid = toBeamGrid(noddingScan(1, 241, 0.0, 0.0, 60 * kDegree));
  const auto labels = scanFaces({wallWith([](const auto&) { return true; })}, grid);
  EXPECT_TRUE(outline(grid, labels).polygons.empty());
}

TEST(RegionPolygons, EmptyInputsAndMismatches) {
  BeamGrid grid = forwardGrid();
  LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(grid.range.size(), 0)};
  EXPECT_TRUE(extractPolygons(grid, labels, {}, {}).empty());
  labels.cols -= 1;
  EXPECT_THROW(extractPolygons(grid, labels, {}, {}), std::invalid_argument);
}

TEST(RegionPolygons, SameInputSameOutput) {
  BeamGrid grid = forwardGrid();
  const auto labels =
      scanFaces({wallWith([](const auto& p) { return std::sin(5 * p.y()) * std::cos(4 * p.z()) > -0.3; })}, grid);
  const auto a = outline(grid, labels).polygons, b = outline(grid, labels).polygons;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].outer, b[i].outer);
    EXPECT_EQ(a[i].holes, b[i].holes);
  }
}

}  // namespace
}  // namespace ppc
