// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/hole_filling.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 60, kCols = 80, kSmallest = 200;
constexpr double kDistance = 3.0;
const CoplanarityTolerance kWhite{0.005, 0.005, 1.0};

// A wall ahead of which a block of pixels has no label.
struct HoledWall {
  NoiseModel noise;
  BeamGrid grid = forwardBeams(kRows, kCols, 0.005);
  LabelImage labels;
  HoleMemory memory;
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::Zero(), Eigen::Vector3d(1.0 / kDistance, 0.0, 0.0)};

  explicit HoledWall(double bump = 0.0, int rows = 8, int cols = 8, double sigma = 0.01)
      : noise(SensorModel{sigma, sigma, 10.0, 0.0}, 1.0) {
    scan({wall({-1.0, 0.0, 0.0}, -kDistance)}, grid);
    addNoise(grid, sigma);
    labels.rows = kRows;
    labels.cols = kCols;
    labels.labels.assign(static_cast<std::size_t>(grid.size()), 1);
    forEachPixel(rows, cols, [&](int i) {
      labels.labels[i] = 0;
      grid.range[i] += static_cast<float>(bump);
    });
  }

  template <typename F>
  void forEachPixel(int rows, int cols, F&& f) const {
    for (int r = 20; r < 20 + rows; ++r) {
      for (int c = 30; c < 30 + cols; ++c) f(grid.index(r, c));
    }
  }

  int unlabelledAfter(const CoplanarityTolerance& tolerance = kWhite) {
    const LabelImage before = labels;
    const bool filled =
        fillHoles({grid, Eigen::Vector3d::Zero(), noise, tolerance, kSmallest}, planes, memory, labels, labelRuns(before));
    EXPECT_EQ(filled, labels.labels != before.labels);
    EXPECT_EQ(std::count(memory.seen.begin(), memory.seen.end(), 0), grid.size());
    return countOf(labels, 0);
  }
};

TEST(FillHoles, GivesPointsOnThePlaneToTheRegionAround) { EXPECT_EQ(HoledWall().unlabelledAfter(), 0); }

TEST(FillHoles, LeavesWhatStandsOffThePlane) {
  EXPECT_EQ(HoledWall(0.03).unlabelledAfter(), 64);
  EXPECT_EQ(HoledWall(-0.03).unlabelledAfter(), 64);
  EXPECT_EQ(HoledWall(1.0).unlabelledAfter(), 64);
}

TEST(FillHoles, AllowsForCorrelatedNoise) {
  CoplanarityTolerance correlated = kWhite;
  correlated.inflation = 16.0;  // bumps of that many points are as uncertain as four points of white noise
  EXPECT_EQ(HoledWall(0.02).unlabelledAfter(correlated), 0);
  EXPECT_EQ(HoledWall(0.06).unlabelledAfter(correlated), 64);
}

// Of 40 mm of noise, the mean of 64 points is known to 5 mm if it is white, and to 14 mm if it is shared by eight of them.
TEST(FillHoles, TellsByTheMeanWhereNoiseIsLarge) {
  CoplanarityTolerance correlated = kWhite;
  correlated.inflation = 8.0;
  EXPECT_EQ(HoledWall(0.02, 8, 8, 0.04).unlabelledAfter(), 0);
  EXPECT_EQ(HoledWall(0.06, 8, 8, 0.04).unlabelledAfter(), 64);
  EXPECT_EQ(HoledWall(0.06, 8, 8, 0.04).unlabelledAfter(correlated), 0);
  EXPECT_EQ(HoledWall(0.12, 8, 8, 0.04).unlabelledAfter(correlated), 64);
}

// Four standard deviations of noise and tolerance are 45 mm.
TEST(FillHoles, GivesSinglePointsWithinNoiseToTheRegionAround) {
  const auto unlabelled = [](double off) {
    HoledWall single(0.0, 1, 1);
    single.forEachPixel(
        1, 1, [&](int i) { single.grid.range[i] = static_cast<float>(kDistance / single.grid.direction(i).x() + off); });
    return single.unlabelledAfter();
  };
  EXPECT_EQ(unlabelled(0.037), 0);
  EXPECT_EQ(unlabelled(-0.037), 0);
  EXPECT_EQ(unlabelled(0.05), 1);
}

TEST(FillHoles, LeavesPointsThatScatterMoreThanNoise) {
  HoledWall scattered;
  int sign = 1;
  scattered.forEachPixel(8, 8, [&](int i) { scattered.grid.range[i] += static_cast<float>((sign = -sign) * 0.05); });
  EXPECT_EQ(scattered.unlabelledAfter(), 64);
}

TEST(FillHoles, LeavesHolesAsLargeAsARegion) {
  EXPECT_EQ(HoledWall(0.0, 14, 14).unlabelledAfter(), 0);
  EXPECT_EQ(HoledWall(0.0, 15, 15).unlabelledAfter(), 225);
}

TEST(FillHoles, LeavesSpecksBetweenTwoRegions) {
  HoledWall two;
  two.planes.push_back(two.planes[1]);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 34; c < kCols; ++c) {
      std::int32_t& label = two.labels.labels[two.grid.index(r, c)];
      if (label == 1) label = 2;
    }
  }
  EXPECT_EQ(two.unlabelledAfter(), 64);
}

TEST(FillHoles, TakesRegionsThatAreTooSmallAsHoles) {
  HoledWall scrap;
  scrap.planes.emplace_back(0.3, 0.1, 0.0);
  scrap.forEachPixel(8, 8, [&](int i) { scrap.labels.labels[i] = 2; });
  EXPECT_EQ(scrap.unlabelledAfter(), 0);
  EXPECT_EQ(countOf(scrap.labels, 2), 0);
}

TEST(FillHoles, LeavesWhatAPlaneWithoutDirectionCannotTell) {
  HoledWall blind;
  blind.planes[1] = Eigen::Vector3d::Zero();  // no beam meets it
  EXPECT_EQ(blind.unlabelledAfter(), 64);
}

TEST(FillHoles, LeavesPixelsWithoutARange) {
  HoledWall holed;
  holed.forEachPixel(2, 2, [&](int i) { holed.grid.range[i] = kNoRange; });
  EXPECT_EQ(holed.unlabelledAfter(), 4);
}

}  // namespace
}  // namespace ppc
