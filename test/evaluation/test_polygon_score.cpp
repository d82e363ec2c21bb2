// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/polygon_score.h"

#include "patch_plane_clustering/evaluation/plane_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace ppc {
namespace {

// A pinhole's beams through (1, y, z), y and z from -1 to 1 in steps of 0.05.
BeamGrid pinhole() {
  std::vector<float> x, y, z;
  for (int r = 0; r < 41; ++r) {
    for (int c = 0; c < 41; ++c) {
      x.push_back(1.0F);
      y.push_back(-1.0F + 0.05F * static_cast<float>(c));
      z.push_back(-1.0F + 0.05F * static_cast<float>(r));
    }
  }
  return beamGridFromPoints(41, 41, x, y, z);
}

PlanarRegion wallAt(double x, int id) {
  PlanarRegion region;
  region.id = id;
  region.plane = {-Eigen::Vector3d::UnitX(), -x};
  return region;
}

// A square on the wall, counter-clockwise seen from the sensor (which looks along +x: y to the left, z up).
std::vector<Eigen::Vector3d> square(double x, double half) {
  return {{x, half, -half}, {x, -half, -half}, {x, -half, half}, {x, half, half}};
}

PlanarPolygon polygon(int id, const std::vector<Eigen::Vector3d>& outer) {
  PlanarPolygon p;
  p.id = id;
  p.outer = outer;
  return p;
}

std::vector<Eigen::Vector3d> reversed(std::vector<Eigen::Vector3d> ring) { return {ring.rbegin(), ring.rend()}; }

TEST(RenderPolygons, FillsWhatTheBeamsGoThroughAndLeavesHoles) {
  PlanarPolygon wall = polygon(3, square(2.0, 1.01));  // covers half the beams each way: |y / x| < 0.505
  wall.holes.push_back(reversed(square(2.0, 0.41)));
  const LabelImage image = renderPolygons(pinhole(), {wallAt(2.0, 3)}, {wall});
  int filled = 0;
  for (const auto label : image.labels) filled += label == 3 ? 1 : 0;
  EXPECT_EQ(filled, 21 * 21 - 9 * 9);
  EXPECT_EQ(image.labels[20 * 41 + 20], 0);
  EXPECT_EQ(image.labels[20 * 41 + 11], 3);
}

TEST(RenderPolygons, TheNearestPolygonHidesTheOthers) {
  const std::vector<PlanarPolygon> polygons = {polygon(1, square(1.0, 0.5)), polygon(2, square(3.0, 2.9))};
  const LabelImage image = renderPolygons(pinhole(), {wallAt(1.0, 1), wallAt(3.0, 2)}, polygons);
  EXPECT_EQ(image.labels[20 * 41 + 20], 1);
  EXPECT_EQ(image.labels[20 * 41 + 3], 2);
}

TEST(RenderPolygons, APolygonBehindTheSensorIsNotSeen) {
  PlanarRegion behind = wallAt(-1.0, 1);
  behind.plane = {Eigen::Vector3d::UnitX(), -1.0};
  const LabelImage image = renderPolygons(pinhole(), {behind}, {polygon(1, square(-1.0, 5.0))});
  for (const auto label : image.labels) ASSERT_EQ(label, 0);
}

TEST(WithoutUnmeasured, ClearsPixelsWithoutAMeasurementOnly) {
  BeamGrid grid = pinhole();
  grid.range[5] = std::nanf("");
  LabelImage labels{41, 41, std::vector<std::int32_t>(41 * 41, 9)};
  labels = withoutUnmeasured(grid, labels);
  EXPECT_EQ(labels.labels[5], 0);
  EXPECT_EQ(labels.labels[6], 9);
  labels.rows = 40;
  EXPECT_THROW(withoutUnmeasured(grid, labels), std::invalid_argument);
}

TEST(PolygonQuality, CountsRingsVerticesAndFaults) {
  PlanarPolygon good = polygon(1, square(2.0, 1.0));
  good.holes.push_back(reversed(square(2.0, 0.5)));
  PlanarPolygon bow_tie = polygon(1, square(2.0, 1.0));
  std::swap(bow_tie.outer[0], bow_tie.outer[1]);
  const PlanarPolygon clockwise = polygon(1, reversed(square(2.0, 1.0)));
  PlanarPolygon outside = polygon(1, square(2.0, 1.0));
  outside.holes.push_back(reversed(square(2.0, 3.0)));
  const PolygonQuality quality = polygonQuality({wallAt(2.0, 1)}, {good, bow_tie, clockwise, outside});
  EXPECT_EQ(quality.polygons, 4);
  EXPECT_EQ(quality.holes, 2);
  EXPECT_EQ(quality.vertices, 24);
  EXPECT_EQ(quality.invalid, 3);
  EXPECT_FALSE(quality.first_fault.empty());
  EXPECT_NEAR(quality.largest_off_plane, 0.0, 1e-12);
}

TEST(PolygonQuality, MeasuresHowFarVerticesAreOffThePlane) {
  PlanarPolygon off = polygon(1, square(2.0, 1.0));
  off.outer[2].x() += 0.03;
  EXPECT_NEAR(polygonQuality({wallAt(2.0, 1)}, {off}).largest_off_plane, 0.03, 1e-12);
}

TEST(PlaneScore, AnglesAndOffsetsOfMatchedRegions) {
  PlanarRegion truth = wallAt(2.0, 1), found = wallAt(2.05, 4);
  truth.centroid = {2.0, 0.0, 0.0};
  const double turn = 0.01;
  found.plane.normal = {-std::cos(turn), std::sin(turn), 0.0};
  found.plane.d = -2.05 * std::cos(turn);
  RegionOverlap overlap;
  overlap.true_ids = {1};
  overlap.found_ids = {4};
  SegcompScore matches;
  matches.matches = {{0, 0}};
  const PlaneScore score = planeScore({truth}, {found}, overlap, matches);
  EXPECT_EQ(score.matched, 1);
  EXPECT_NEAR(score.mean_normal_error, turn, 1e-12);
  EXPECT_NEAR(score.mean_offset_error, 0.05 * std::cos(turn), 1e-12);
}

// Of four planes off by known multiples of their standard deviations; the last has no covariance.
TEST(PlaneScore, ErrorsInUnitsOfTheCovariance) {
  std::vector<PlanarRegion> truth, found;
  RegionOverlap overlap;
  SegcompScore matches;
  for (int k = 0; k < 4; ++k) {
    truth.push_back(wallAt(2.0, k + 1));
    truth[k].centroid = {2.0, 0.0, 0.0};
    found.push_back(truth[k]);
    overlap.true_ids.push_back(k + 1);
    overlap.found_ids.push_back(k + 1);
    matches.matches.emplace_back(k, k);
  }
  const double turn = 0.01, offset = 0.02;
  for (int k = 0; k < 3; ++k) {  // turns about z and y, each with the change of d that keeps the centroid; and d alone
    const Eigen::Vector4d about_z(0.0, 1.0, 0.0, 0.0), about_y(0.0, 0.0, 1.0, 0.0), along(0.0, 0.0, 0.0, 1.0);
    found[k].covariance = turn * turn * (about_z * about_z.transpose() + about_y * about_y.transpose()) +
                          offset * offset * along * along.transpose();
  }
  found[0].plane.d += 2.0 * offset;
  found[1].plane.normal = Eigen::Vector3d(-1.0, turn, 0.0).normalized();
  found[2].plane.normal = Eigen::Vector3d(-1.0, 2.0 * turn, 0.0).normalized();
  found[2].plane.d -= 2.0 * offset;
  EXPECT_NEAR(normalisedErrorSquared(truth[0], found[0]), 4.0, 1e-9);
  EXPECT_NEAR(normalisedErrorSquared(truth[1], found[1]), 1.0, 1e-3);
  EXPECT_NEAR(normalisedErrorSquared(truth[2], found[2]), 8.0, 0.1);
  EXPECT_EQ(normalisedErrorSquared(truth[3], found[3]), std::numeric_limits<double>::infinity());
  const PlaneScore score = planeScore(truth, found, overlap, matches);
  EXPECT_NEAR(score.median_normalised_error, 8.0, 0.1);
  EXPECT_EQ(score.within_95, 0.5);
}

TEST(PlaneScore, ARefitIsComparedWithTheTruthOfItsOwnRegion) {
  const PlanarRegion truth_a = wallAt(2.0, 1), truth_b = wallAt(3.0, 2);
  const PlanarRegion refit_a = wallAt(2.01, 1), refit_b = wallAt(3.03, 2);
  RegionOverlap overlap;
  overlap.true_ids = {1, 2};
  overlap.found_ids = {7, 9};
  SegcompScore matches;
  matches.matches = {{1, 0}};  // only the second region was found
  PlanarRegion truth = truth_b;
  truth.centroid = {3.0, 0.5, 0.2};
  const PlaneScore score = refitScore({truth_a, truth}, {refit_a, refit_b}, overlap, matches);
  EXPECT_EQ(score.matched, 1);
  EXPECT_NEAR(score.mean_offset_error, 0.03, 1e-12);
  EXPECT_NEAR(score.mean_normal_error, 0.0, 1e-12);
}

TEST(Compression, IsBytesOfPointsOverBytesOfPolygons) {
  PolygonQuality quality;
  EXPECT_DOUBLE_EQ(compression(1000, quality), 0.0);
  quality.polygons = 2;
  quality.holes = 1;
  quality.vertices = 4 + 4 + 6;
  EXPECT_DOUBLE_EQ(compression(10000, quality), 120000.0 / (14 * 12 + 2 * 32 + 3 * 4));
}

}  // namespace
}  // namespace ppc
