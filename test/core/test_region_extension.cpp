// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_extension.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 60, kCols = 120, kSmallest = 200;
const NoiseModel kNoise(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0);
const CoplanarityTolerance kWhite{0.005, 0.005, 1.0};

// A wall at x = 3, of which columns up to 60 have label 1; nothing else has any.
struct HalfKnownWall {
  BeamGrid grid = forwardBeams(kRows, kCols, 0.005);
  LabelImage labels;
  ExtensionMemory memory;
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::Zero(), Eigen::Vector3d(1.0 / 3.0, 0.0, 0.0)};

  explicit HalfKnownWall(const std::vector<Surface>& surfaces = {wall({-1.0, 0.0, 0.0}, -3.0)}) {
    labels = scan(surfaces, grid);
    addNoise(grid, 0.01);
    forEachPixel([&](int i, int, int c) { labels.labels[i] = c < 60 ? 1 : 0; });
  }

  template <typename F>
  void forEachPixel(F&& f) const {
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kCols; ++c) f(grid.index(r, c), r, c);
    }
  }

  int pointsAfter(const CoplanarityTolerance& tolerance = kWhite, int threads = 1) {
    const LabelImage before = labels;
    const bool extended = extendRegions({grid, Eigen::Vector3d::Zero(), kNoise, tolerance, kSmallest}, planes, memory,
                                        labels, labelRuns(before), threads);
    EXPECT_EQ(extended, labels.labels != before.labels);
    EXPECT_EQ(std::count(memory.tried.begin(), memory.tried.end(), 0), grid.size());
    return countOf(labels, 1);
  }
};

TEST(ExtendRegions, GoesToTheEndOfThePlane) {
  EXPECT_GT(HalfKnownWall().pointsAfter(), 0.99 * kRows * kCols);  // but for points 3 standard deviations off
}

TEST(ExtendRegions, GoesAlongAStripOfTwoPixels) {
  HalfKnownWall strip;
  strip.forEachPixel([&](int i, int r, int c) {
    const int top = c / 8;  // goes down slowly
    if (c >= 60 && r != top && r != top + 1) strip.grid.range[i] += 1.0F;
  });
  EXPECT_NEAR(strip.pointsAfter(), kRows * 60 + 2 * 60, 6);
}

TEST(ExtendRegions, LeavesWhatCrossesThePlane) {
  // From column 60 on, a face that turns away by 8 degrees: within three standard deviations over some columns.
  for (const double turn : {0.14, 0.3, 1.0}) {
    HalfKnownWall corner({wall({-1.0, 0.0, 0.0}, -3.0), wall({-1.0, -turn, 0.0}, -3.0)});
    EXPECT_EQ(corner.pointsAfter(), kRows * 60) << turn;
  }
  HalfKnownWall crossed;
  crossed.planes[1] = Eigen::Vector3d(1.0, 0.0, 0.2) / 3.0;  // meets the wall in the middle row
  EXPECT_EQ(crossed.pointsAfter(), kRows * 60);
}

TEST(ExtendRegions, LeavesWhatStandsOffThePlane) {
  HalfKnownWall stepped;
  stepped.forEachPixel([&](int i, int, int c) { stepped.grid.range[i] += c < 60 ? 0.0F : 0.015F; });
  EXPECT_EQ(stepped.pointsAfter(), kRows * 60);
}

TEST(ExtendRegions, AllowsForCorrelatedNoise) {
  CoplanarityTolerance correlated = kWhite;
  correlated.inflation = 2000.0;  // so many points are as uncertain as one or two of white noise
  HalfKnownWall bump;
  bump.forEachPixel([&](int i, int, int c) { bump.grid.range[i] += c < 60 ? 0.0F : 0.008F; });
  EXPECT_EQ(HalfKnownWall(bump).pointsAfter(), kRows * 60);
  EXPECT_GT(bump.pointsAfter(correlated), 0.9 * kRows * kCols);
}

TEST(ExtendRegions, LeavesAFewPoints) {
  for (const int rows : {15, 16}) {
    HalfKnownWall scrap;
    scrap.forEachPixel([&](int i, int r, int c) {
      if (c > 60 || (c == 60 && r >= rows)) scrap.grid.range[i] = kNoRange;
      if (c == 60 && r < rows) scrap.grid.range[i] = static_cast<float>(3.0 / scrap.grid.direction(i).x());
    });
    EXPECT_EQ(scrap.pointsAfter(), kRows * 60 + (rows < 16 ? 0 : 16));
  }
}

TEST(ExtendRegions, NeitherTakesFromARegionNorExtendsAScrap) {
  HalfKnownWall two;
  two.planes.push_back(two.planes[1]);
  two.forEachPixel([&](int i, int, int c) {
    if (c >= 60 && c < 70) two.labels.labels[i] = 2;
  });
  EXPECT_EQ(two.pointsAfter(), kRows * 60);  // 2 has gone on to the end
  EXPECT_GT(countOf(two.labels, 2), 0.98 * kRows * 60);

  HalfKnownWall scrap;
  scrap.forEachPixel([&](int i, int r, int c) { scrap.labels.labels[i] = r < 2 && c < 60 ? 1 : 0; });
  EXPECT_EQ(scrap.pointsAfter(), 120);
}

TEST(ExtendRegions, TakesRegionsThatAreTooSmall) {
  HalfKnownWall scrap;
  scrap.planes.emplace_back(0.3, 0.1, 0.0);
  scrap.forEachPixel([&](int i, int r, int c) {
    if (c >= 70 && c < 78 && r < 8) scrap.labels.labels[i] = 2;
  });
  EXPECT_GT(scrap.pointsAfter(), 0.99 * kRows * kCols);
  EXPECT_EQ(countOf(scrap.labels, 2), 0);
}

TEST(ExtendRegions, LeavesWhatAPlaneWithoutDirectionCannotTell) {
  HalfKnownWall blind;
  blind.planes[1] = Eigen::Vector3d::Zero();  // no beam meets it
  EXPECT_EQ(blind.pointsAfter(), kRows * 60);
}

TEST(ExtendRegions, DoesTheSameOnAnyNumberOfThreads) {
  HalfKnownWall one;
  one.forEachPixel([&](int i, int r, int c) {
    if (c > 80 && (r + c) % 9 == 0) one.grid.range[i] = kNoRange;
  });
  HalfKnownWall three = one;
  one.pointsAfter();
  three.pointsAfter(kWhite, 3);
  EXPECT_EQ(one.labels.labels, three.labels.labels);
}

}  // namespace
}  // namespace ppc
