// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include "naive_beam_fit.h"
#include "polygon_test_tools.h"
#include "run_checks.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

using namespace testing_tools;

const auto kAnywhere = [](const Eigen::Vector3d&) { return true; };

TEST(RegionStatistics, PlaneIsExactWithoutNoiseFromNearToFar) {
  for (const double distance : {0.1, 1.0, 5.0, 30.0}) {
    BeamGrid grid = toBeamGrid(noddingScan(40, 60, -15 * kDegree, 15 * kDegree, 20 * kDegree));
    const Eigen::Vector3d normal = Eigen::Vector3d(-1.0, 0.3, -0.2).normalized();
    const auto labels = scanFaces({{{normal, -distance}, kAnywhere}}, grid);
    const auto regions = describeRegions(grid, labels);
    ASSERT_EQ(regions.size(), 1U);
    EXPECT_EQ(regions[0].id, 1);
    EXPECT_EQ(regions[0].points, 2400);
    EXPECT_LT((regions[0].plane.normal - normal).norm(), 2e-6) << distance;
    EXPECT_NEAR(regions[0].plane.d, -distance, 2e-6 * distance);
    EXPECT_LT(regions[0].rms, 1e-6 * distance);
  }
}

TEST(RegionStatistics, CentroidRmsAndCountOfKnownPoints) {
  // Four points of a square at x = 2, 1 cm in front and behind in turn: the residuals, but not the plane, see it.
  const std::vector<float> x{1.99F, 2.01F, 2.01F, 1.99F}, y{-1, 1, -1, 1}, z{-1, -1, 1, 1};
  const BeamGrid grid = beamGridFromPoints(2, 2, x, y, z);
  const auto regions = describeRegions(grid, {2, 2, {3, 3, 3, 3}});
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].id, 3);
  EXPECT_EQ(regions[0].points, 4);
  EXPECT_LT((regions[0].centroid - Eigen::Vector3d(2, 0, 0)).norm(), 1e-6);
  EXPECT_LT((regions[0].plane.normal + Eigen::Vector3d::UnitX()).norm(), 1e-4);  // towards the sensor
  EXPECT_NEAR(regions[0].plane.d, -2.0, 1e-4);
  EXPECT_NEAR(regions[0].rms, 0.01, 1e-4);
}

TEST(RegionStatistics, InvalidPixelsAndTinyRegionsDoNotCount) {
  BeamGrid grid = toBeamGrid(noddingScan(10, 10, -0.1, 0.1, 0.1));
  LabelImage labels = scanFaces({{{-Eigen::Vector3d::UnitX(), -2.0}, kAnywhere}}, grid);
  labels.labels[0] = labels.labels[1] = 2;  // two points make no plane
  for (int i = 50; i < 60; ++i) grid.range[i] = std::numeric_limits<float>::quiet_NaN();
  const auto regions = describeRegions(grid, labels);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].points, 88);
  EXPECT_TRUE(describeRegions(grid, {10, 10, std::vector<std::int32_t>(100, 0)}).empty());
}

struct Scan {
  const char* what;
  BeamGrid grid;
  Plane truth;
  double sigma;           // of the noise [m]
  double reach = 40.0;    // [m]
  bool cautious = false;  // errors across the beams, which this scan has none of, would count at this angle

  LabelImage measure() {
    return scanFaces({{truth, [this](const Eigen::Vector3d& p) { return p.norm() < reach; }}}, grid);
  }
};

// Seen from near and far, edge-on, as a strip that is narrower than the noise, and all around the pole of the scan.
std::vector<Scan> difficultScans() {
  const auto tilted = [](double slant, double d) {
    return Plane{Eigen::Vector3d(-std::cos(slant), std::sin(slant), 0.1).normalized(), d};
  };
  const auto nodding = [](int rows, int cols, double tilt, double bearing, double lever) {
    return toBeamGrid(
        noddingScan(rows, cols, -tilt * kDegree, tilt * kDegree, bearing * kDegree, {lever, 0.0, 0.4 * lever}));
  };
  return {{"near", nodding(20, 30, 10, 15, 0.05), tilted(0.0, -2.0), 0.01},
          {"slanted", nodding(20, 30, 10, 15, 0.05), tilted(0.8, -2.0), 0.01},
          {"edge-on", nodding(60, 80, 8, 8, 0.0), tilted(1.4, -0.3), 0.01, 40.0, true},
          {"far", nodding(60, 80, 2, 3, 0.05), tilted(0.5, -28.0), 0.03},
          {"small", nodding(6, 8, 2, 2, 0.05), tilted(0.3, -2.0), 0.01},
          {"strip", nodding(6, 200, 0.8, 15, 0.05), tilted(0.2, -1.0), 0.03},
          {"large", nodding(150, 400, 40, 60, 0.05), tilted(0.1, -3.0), 0.01},
          {"pole", nodding(90, 180, 85, 90, 0.02), {Eigen::Vector3d::UnitZ(), -0.8}, 0.01, 4.0}};
}

// Normalised error squared of the plane's parameters over many noisy scans: chi-square with 3 degrees of freedom, if the
// covariance is right. Band: three standard deviations of the mean, and what few points take from the normal distribution.
TEST(RegionStatistics, CovarianceHoldsUnderMonteCarlo) {
  for (Scan& scan : difficultScans()) {
    const auto labels = scan.measure();
    const int points = countOf(labels, 1), runs = points < 1000 ? 400 : points < 10000 ? 100 : 60;
    Normal normal(11);
    double sum = 0.0, bias = 0.0;
    for (int run = 0; run < runs; ++run) {
      BeamGrid grid = scan.grid;
      for (float& range : grid.range) range += static_cast<float>(scan.sigma * normal());
      const auto regions = describeRegions(grid, labels);
      ASSERT_EQ(regions.size(), 1U) << scan.what;
      const PlanarRegion& region = regions[0];
      sum += normalisedErrorSquared(region, scan.truth);
      bias += (region.plane.d - scan.truth.d) / runs;
      ASSERT_LT((region.covariance - region.covariance.transpose()).norm(), 1e-12);
      const Eigen::Vector3d along = region.covariance.topLeftCorner<3, 3>() * region.plane.normal;
      ASSERT_LT(along.norm(), 1e-12 + 1e-9 * region.covariance.norm()) << scan.what;  // |n| = 1
    }
    const double band = 3.0 * std::sqrt(6.0 / runs) + 20.0 / points;
    EXPECT_LT(sum / runs, 3.0 + band) << scan.what << ' ' << points;
    EXPECT_GT(sum / runs, (scan.cautious ? 2.0 : 3.0) - band) << scan.what << ' ' << points;
    EXPECT_LT(std::abs(bias), 0.2 * scan.sigma) << scan.what;
  }
}

// Errors of unit variance, a pixel each.
using Errors = std::function<std::vector<double>(int rows, int cols, Normal& normal)>;

std::vector<double> whiteErrors(int rows, int cols, Normal& normal) {
  std::vector<double> errors(static_cast<std::size_t>(rows) * cols);
  for (double& error : errors) error = normal();
  return errors;
}

// Means over rectangles of white ones.
Errors smoothErrors(int height, int width) {
  return [=](int rows, int cols, Normal& normal) {
    const int wide = cols + width - 1;
    const std::vector<double> white = whiteErrors(rows + height - 1, wide, normal);
    std::vector<double> errors(static_cast<std::size_t>(rows) * cols, 0.0);
    for (int i = 0; i < rows * cols; ++i) {
      for (int r = 0; r < height; ++r) {
        for (int c = 0; c < width; ++c) errors[i] += white[(i / cols + r) * wide + i % cols + c];
      }
      errors[i] /= std::sqrt(width * height);
    }
    return errors;
  };
}

// @param share of the variance, which is the same for all of a line.
Errors lineErrors(double share) {
  return [=](int rows, int cols, Normal& normal) {
    std::vector<double> errors = whiteErrors(rows, cols, normal);
    for (int r = 0; r < rows; ++r) {
      const double line = std::sqrt(share) * normal();
      for (int c = 0; c < cols; ++c) errors[r * cols + c] = std::sqrt(1.0 - share) * errors[r * cols + c] + line;
    }
    return errors;
  };
}

// Mean normalised error squared of each region, over many scans. @param planes true ones.
std::vector<double> meanErrorsSquared(const BeamGrid& exact, const LabelImage& labels, const std::vector<Plane>& planes,
                                      const Errors& errors, double sigma, int runs) {
  Normal normal(3);
  std::vector<double> mean(planes.size(), 0.0);
  for (int run = 0; run < runs; ++run) {
    BeamGrid grid = exact;
    const std::vector<double> of = errors(grid.rows, grid.cols, normal);
    for (int i = 0; i < grid.size(); ++i) grid.range[i] += static_cast<float>(sigma * of[i]);
    const auto regions = describeRegions(grid, labels);
    EXPECT_EQ(regions.size(), planes.size());
    if (regions.size() != planes.size()) return {};
    for (std::size_t k = 0; k < planes.size(); ++k) mean[k] += normalisedErrorSquared(regions[k], planes[k]) / runs;
  }
  return mean;
}

// As above, also where errors are not independent. Taken for independent, their squares would be 4 to 60 times too large.
TEST(RegionStatistics, CovarianceHoldsWhereErrorsGoTogether) {
  const auto wall = [](double distance) { return Plane{-Eigen::Vector3d::UnitX(), -distance}; };
  BeamGrid exact = toBeamGrid(noddingScan(160, 320, -30 * kDegree, 30 * kDegree, 40 * kDegree));
  const std::vector<Face> faces{{wall(3.0), [](const auto& p) { return p.y() < 0.2 && p.z() < 0.5; }},
                                {wall(3.1), [](const auto& p) { return p.y() > 0.2 && p.z() > 0.3; }},
                                {wall(3.2), [](const auto& p) { return p.y() > 0.2 && p.z() < 0.2; }},
                                {wall(3.3), [](const auto& p) { return std::abs(p.z() - 0.8) < 0.15; }}};
  const LabelImage labels = scanFaces(faces, exact);
  std::vector<Plane> planes;
  for (const Face& face : faces) planes.push_back(face.plane);
  struct Kind {
    const char* what;
    Errors errors;
    double most;
  };
  for (const Kind& kind : {Kind{"white", whiteErrors, 3.8}, Kind{"along lines", smoothErrors(1, 5), 3.8},
                           Kind{"of lines", lineErrors(0.2), 3.8}, Kind{"smooth", smoothErrors(8, 8), 12.0}}) {
    const std::vector<double> mean = meanErrorsSquared(exact, labels, planes, kind.errors, 0.01, 100);
    ASSERT_EQ(mean.size(), planes.size());
    for (const double error : mean) {
      EXPECT_LT(error, kind.most) << kind.what;
      EXPECT_GT(error, 1.5) << kind.what;
    }
  }
}

// What all points of a line have in common shows only if no line is in two parts: of wide ones, or where a post stands
// before them.
TEST(RegionStatistics, CovarianceHoldsForLinesInSeveralPieces) {
  BeamGrid exact = toBeamGrid(noddingScan(40, 700, -15 * kDegree, 15 * kDegree, 50 * kDegree));
  const Plane wall{-Eigen::Vector3d::UnitX(), -3.0};
  const LabelImage whole = scanFaces({{wall, kAnywhere}}, exact);
  LabelImage posts = whole;
  for (int i = 0; i < exact.size(); ++i) {
    if (i % exact.cols / 20 % 4 == 3) posts.labels[i] = 0;
  }
  for (const LabelImage& labels : {whole, posts}) {
    const std::vector<double> mean = meanErrorsSquared(exact, labels, {wall}, lineErrors(0.2), 0.01, 60);
    ASSERT_EQ(mean.size(), 1U);
    EXPECT_LT(mean[0], 3.8);
    EXPECT_GT(mean[0], 1.5);
  }
}

// What is left out of the fit must not tell how its errors scatter.
TEST(RegionStatistics, CovarianceIsThatOfThePointsOfThePlane) {
  BeamGrid exact = toBeamGrid(noddingScan(24, 100, -6 * kDegree, 6 * kDegree, 20 * kDegree));
  const Plane wall{-Eigen::Vector3d::UnitX(), -2.0};
  const LabelImage labels = scanFaces({{wall, kAnywhere}}, exact);
  for (int c = 0; c < exact.cols; ++c) exact.range[c] += 0.04F;
  const std::vector<double> mean = meanErrorsSquared(exact, labels, {wall}, whiteErrors, 0.02, 60);
  ASSERT_EQ(mean.size(), 1U);
  EXPECT_LT(mean[0], 4.0);
  EXPECT_GT(mean[0], 1.5);
}

// A level line tells one turn of its plane not at all.
TEST(RegionStatistics, CovarianceOfALineIsFiniteAndSymmetric) {
  BeamGrid grid = forwardBeams(1, 50, 0.003);
  const LabelImage labels = scanFaces({{{-Eigen::Vector3d::UnitX(), -3.0}, kAnywhere}}, grid);
  for (const double sigma : {0.0, 0.001}) {
    addNoise(grid, sigma);
    for (const PlanarRegion& region : describeRegions(grid, labels)) {
      EXPECT_TRUE(region.covariance.allFinite()) << sigma;
      EXPECT_EQ(region.covariance, region.covariance.transpose()) << sigma;
    }
  }
}

// The converged fit, without points beyond 2.5 standard deviations, lies within the error of either.
TEST(RegionStatistics, OnePassReachesTheConvergedPlane) {
  for (Scan& scan : difficultScans()) {
    const auto labels = scan.measure();
    addNoise(scan.grid, scan.sigma);
    const auto regions = describeRegions(scan.grid, labels);
    ASSERT_EQ(regions.size(), 1U) << scan.what;
    const std::vector<int> pixels = pixelsOf(scan.grid, labels, 1);
    const double softness = pixels.size() < 64 ? 0.0 : std::pow(0.0025 / scan.sigma, 2.0);  // errors across, see BeamStart
    const Plane squares = naiveBeamFit(scan.grid, pixels, scan.truth, 1e9, softness);
    const double limit = pixels.size() < 64 ? 1e9 : naiveLimit(scan.grid, pixels, squares);
    const Plane trimmed = naiveBeamFit(scan.grid, pixels, squares, limit, softness);
    EXPECT_LT(normalisedErrorSquared(regions[0], trimmed), scan.cautious ? 2.0 : 0.6) << scan.what;  // softness is estimated
    double across = 0.0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int i : pixels) {
      across += std::pow(regions[0].plane.signedDistance(scan.grid.point(i).cast<double>()), 2.0);
      mean += scan.grid.point(i).cast<double>();
    }
    const auto n = static_cast<double>(pixels.size());
    EXPECT_NEAR(regions[0].rms, std::sqrt(across / n), 5e-3 * regions[0].rms) << scan.what;
    EXPECT_LT((regions[0].centroid - mean / n).norm(), 1e-5) << scan.what;
    EXPECT_EQ(regions[0].points, static_cast<int>(pixels.size()));
  }
}

// Points of a step beside a wall that have got its label: they would turn the plane as far as they can.
TEST(RegionStatistics, WrongPointsBesideAStepHardlyTurnThePlane) {
  BeamGrid grid = toBeamGrid(noddingScan(40, 60, -10 * kDegree, 10 * kDegree, 15 * kDegree));
  const Plane wall{-Eigen::Vector3d::UnitX(), -2.0}, step{-Eigen::Vector3d::UnitX(), -1.95};
  const auto beside = [](const Eigen::Vector3d& p) { return p.y() > 0.9 * 2.0 * std::tan(15 * kDegree); };
  auto labels = scanFaces({{wall, kAnywhere}, {step, beside}}, grid);
  const int wrong = countOf(labels, 2);
  EXPECT_NEAR(wrong, 0.05 * grid.size(), 0.01 * grid.size());
  std::fill(labels.labels.begin(), labels.labels.end(), 1);
  addNoise(grid, 0.01);
  const auto regions = describeRegions(grid, labels);
  ASSERT_EQ(regions.size(), 1U);
  const std::vector<int> pixels = pixelsOf(grid, labels, 1);
  const Plane squares = naiveBeamFit(grid, pixels, wall);
  EXPECT_GT(angleBetween(squares.normal, wall.normal), 0.5 * kDegree);
  EXPECT_LT(angleBetween(regions[0].plane.normal, wall.normal), 0.15 * kDegree);
  EXPECT_NEAR(regions[0].plane.d, wall.d, 0.001);
  EXPECT_NEAR(regions[0].rms, std::sqrt(1e-4 + 0.05 * 0.05 * wrong / grid.size()), 5e-4);  // of all points
}

// The riser of a stair, some rows high, that has got a row of each tread over a third of its width: all of them within the
// noise, and each row on another side of the plane. Of four rows, they turn the plane so far that only the inside tells.
TEST(RegionStatistics, RowsOfTheTreadsDoNotTurnARiser) {
  const Plane riser{-Eigen::Vector3d::UnitX(), -2.0};
  constexpr int kCols = 150, kRuns = 24;
  for (const int rows : {6, 8}) {
    double turned = 0.0, squares_turned = 0.0;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      BeamGrid grid =
          toBeamGrid(noddingScan(rows, kCols, -0.2 * (rows - 1) * kDegree, 0.2 * (rows - 1) * kDegree, 20 * kDegree));
      LabelImage labels = scanFaces({{riser, kAnywhere}}, grid);
      addNoise(grid, 0.03, 0.0, 0.0, seed);
      for (int c = 0; c < kCols; ++c) {
        for (const int r : {0, rows - 1}) {
          if (c >= kCols / 3 && c < 2 * kCols / 3) {
            grid.range[grid.index(r, c)] += r == 0 ? 0.04F : -0.04F;
          } else {
            labels.labels[grid.index(r, c)] = 0;
          }
        }
      }
      const auto regions = describeRegions(grid, labels);
      ASSERT_EQ(regions.size(), 1U);
      EXPECT_EQ(regions[0].points, (rows - 2) * kCols + 2 * kCols / 3);
      turned += angleBetween(regions[0].plane.normal, riser.normal) / kRuns;
      squares_turned += angleBetween(naiveBeamFit(grid, pixelsOf(grid, labels, 1), riser).normal, riser.normal) / kRuns;
    }
    EXPECT_GT(squares_turned, 8 * kDegree);
    EXPECT_LT(turned, (rows == 6 ? 0.4 : 0.25) * squares_turned);
  }
}

// Its outermost rows stand 6 mm off the others, as those of a wall that bows may: they are still part of it.
TEST(RegionStatistics, ANarrowRegionThatBowsKeepsItsFringe) {
  const Plane wall{-Eigen::Vector3d::UnitX(), -2.0};
  constexpr int kRows = 6, kCols = 150, kRuns = 8;
  double moved = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    BeamGrid grid = toBeamGrid(noddingScan(kRows, kCols, -1.0 * kDegree, 1.0 * kDegree, 20 * kDegree));
    const LabelImage labels = scanFaces({{wall, kAnywhere}}, grid);
    addNoise(grid, 0.01, 0.0, 0.0, seed);
    for (int c = 0; c < kCols; ++c) {
      for (const int r : {0, kRows - 1}) grid.range[grid.index(r, c)] += 0.006F;
    }
    const auto regions = describeRegions(grid, labels);
    ASSERT_EQ(regions.size(), 1U);
    moved += (wall.d - regions[0].plane.d) / kRuns;
  }
  EXPECT_NEAR(moved, 0.006 * 2.0 / kRows, 0.0005);
}

// All beams lie in the plane: the points tell it, if the beams do not.
TEST(RegionStatistics, PlaneThroughTheSensorIsFitAcross) {
  std::vector<float> x, y, z;
  for (int i = 0; i < 400; ++i) {
    x.push_back(1.0F + 0.1F * static_cast<float>(i % 20));
    y.push_back(i % 2 == 0 ? 0.001F : -0.001F);
    z.push_back(0.02F * static_cast<float>(i / 20) - 0.2F);
  }
  const auto regions = describeRegions(beamGridFromPoints(20, 20, x, y, z), {20, 20, std::vector<std::int32_t>(400, 1)});
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_GT(std::abs(regions[0].plane.normal.y()), 0.9999);
  EXPECT_NEAR(regions[0].rms, 0.001, 1e-5);
}

// Bowed by 3 cm, in as many rows as make runs at even distances lie above each other: a sample of one strip of it would tell
// another plane, and a limit that leaves most of it out.
TEST(RegionStatistics, ABowedWallIsFittedOverAllOfItsWidth) {
  BeamGrid grid = toBeamGrid(noddingScan(64, 1080, -8 * kDegree, 8 * kDegree, 30 * kDegree));
  const Plane wall{-Eigen::Vector3d::UnitX(), -3.0};
  const LabelImage labels = scanFaces({{wall, kAnywhere}}, grid);
  addNoise(grid, 0.01);
  const double half = 3.0 * std::tan(30 * kDegree);
  for (int i = 0; i < grid.size(); ++i) grid.range[i] += static_cast<float>(0.03 * std::pow(grid.point(i).y() / half, 2.0));
  const auto regions = describeRegions(grid, labels);
  ASSERT_EQ(regions.size(), 1U);
  const Plane squares = naiveBeamFit(grid, pixelsOf(grid, labels, 1), wall);
  EXPECT_LT(angleBetween(regions[0].plane.normal, squares.normal), 0.03 * kDegree);
}

// Two pixels wide, as is a door's edge, with some wrong points: the sample must have enough to tell them.
TEST(RegionStatistics, WrongPointsDoNotMoveAThinRegion) {
  BeamGrid grid = toBeamGrid(noddingScan(300, 40, -30 * kDegree, 30 * kDegree, 5 * kDegree));
  const Plane wall{Eigen::Vector3d(-1.0, 0.3, 0.0).normalized(), -2.0};
  LabelImage labels = scanFaces({{wall, kAnywhere}}, grid);
  addNoise(grid, 0.01);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      if (c < 20 || c > 21) labels.labels[grid.index(r, c)] = 0;
      if (r % 16 == 3) grid.range[grid.index(r, c)] += 0.15F;
    }
  }
  const auto regions = describeRegions(grid, labels);
  ASSERT_EQ(regions.size(), 1U);
  const Eigen::Vector3d middle = regions[0].centroid - wall.signedDistance(regions[0].centroid) * wall.normal;
  EXPECT_LT(std::abs(regions[0].plane.signedDistance(middle)), 0.003);
}

TEST(RegionStatistics, ThreadsChangeNothing) {
  for (Scan& scan : difficultScans()) {
    const auto labels = scan.measure();
    addNoise(scan.grid, scan.sigma);
    const auto one = describeRegions(scan.grid, labels, 1), four = describeRegions(scan.grid, labels, 4);
    ASSERT_EQ(one.size(), four.size());
    EXPECT_EQ(one[0].plane.normal, four[0].plane.normal);
    EXPECT_EQ(one[0].plane.d, four[0].plane.d);
    EXPECT_EQ(one[0].rms, four[0].rms);
    EXPECT_EQ(one[0].covariance, four[0].covariance);
  }
}

TEST(RegionStatistics, RenumberingIsBySizeThenByPlace) {
  BeamGrid grid = toBeamGrid(noddingScan(2, 6, -0.1, 0.1, 0.5));
  std::fill(grid.range.begin(), grid.range.end(), 1.0F);
  grid.range[11] = std::numeric_limits<float>::quiet_NaN();
  LabelImage labels{2, 6, {7, 7, 4, 4, 4, 4, 2, 2, 9, -5, 0, 4}};
  RenumberingMemory memory;
  std::vector<LabelRun> runs;
  int valid_points = 0;
  EXPECT_EQ(renumberBySize(grid, 2, memory, labels, runs, valid_points), 3);
  EXPECT_EQ(valid_points, 11);
  EXPECT_EQ(labels.labels, (std::vector<std::int32_t>{2, 2, 1, 1, 1, 1, 3, 3, 0, 0, 0, 0}));
  testing_tools::expectRunsOf(labels, runs);
}

// Runs that are longer than what is looked at in one go, and some that end with it.
TEST(RegionStatistics, RenumberingListsLongRuns) {
  BeamGrid grid = toBeamGrid(noddingScan(9, 1024, -0.1, 0.1, 0.5));
  std::fill(grid.range.begin(), grid.range.end(), 1.0F);
  for (const int i : {10, 4095, 9000}) grid.range[i] = std::numeric_limits<float>::quiet_NaN();
  RenumberingMemory memory;
  std::vector<LabelRun> runs{{9, 0, 1}};
  for (const int threads : {1, 3, 2}) {
    LabelImage labels{9, 1024, std::vector<std::int32_t>(9 * 1024, 3)};
    std::fill(labels.labels.begin() + 8192, labels.labels.end(), 2);
    int valid_points = 0;
    EXPECT_EQ(renumberBySize(grid, 2, memory, labels, runs, valid_points, threads), 2);
    EXPECT_EQ(valid_points, 9 * 1024 - 3);
    testing_tools::expectRunsOf(labels, runs);
    EXPECT_EQ(runs.size(), 5U);
  }
}

}  // namespace
}  // namespace ppc
