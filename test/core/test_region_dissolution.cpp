// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_dissolution.h"

#include "analytic_scenes.h"
#include "run_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr int kRows = 90, kCols = 120, kSmallest = 100, kEdge = 60;
constexpr double kSigma = 0.04, kNear = 3.0, kFar = 3.06;
const NoiseModel kNoise(SensorModel{kSigma, kSigma, 10.0, 0.0}, 1.0);
const CoplanarityTolerance kTolerance{0.005, 0.005, 1.0};

// A low step in a wall at column kEdge, with noise: label 1 in front of it, 2 behind it, and a third label for columns
// [begin, end) of all rows but the first few.
struct Step {
  BeamGrid grid = forwardBeams(kRows, kCols, 0.005);
  LabelImage labels{kRows, kCols, {}};
  DissolutionMemory memory;
  std::vector<Eigen::Vector3d> planes{Eigen::Vector3d::Zero(), at(kNear), at(kFar)};

  Step(int begin, int end, double distance) {
    const auto left = [this](const Eigen::Vector3d& p) {
      return p.y() / p.x() < -0.5 * (kCols - 1) * 0.005 + 0.005 * (kEdge - 0.5);
    };
    labels = scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -kNear}, left}), wall({-1.0, 0.0, 0.0}, -kFar)}, grid);
    addNoise(grid, kSigma);
    planes.push_back(at(distance));
    forEachPixel(begin, end, [&](int i) { labels.labels[i] = 3; });
  }

  static Eigen::Vector3d at(double distance) { return {1.0 / distance, 0.0, 0.0}; }

  template <typename F>
  void forEachPixel(int begin, int end, F&& f) const {
    for (int r = 5; r < kRows; ++r) {
      for (int c = begin; c < end; ++c) f(grid.index(r, c));
    }
  }

  int left(int smallest = kSmallest, const CoplanarityTolerance& tolerance = kTolerance) {
    std::vector<LabelRun> runs = labelRuns(labels);
    dissolveRegions({grid, Eigen::Vector3d::Zero(), kNoise, tolerance, smallest}, planes, memory, labels, runs);
    expectRunsOf(labels, runs);
    return countOf(labels, 3);
  }

  double shareOf(std::int32_t label, int begin, int end) const {
    int all = 0, of_label = 0;
    forEachPixel(begin, end, [&](int i) {
      ++all;
      of_label += labels.labels[i] == label ? 1 : 0;
    });
    return static_cast<double>(of_label) / all;
  }
};

TEST(DissolveRegions, GivesTheTraceOfAStepToTheFacesBeside) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  EXPECT_EQ(step.left(), 0);
  EXPECT_GT(step.shareOf(1, kEdge - 3, kEdge), 0.8);
  EXPECT_GT(step.shareOf(2, kEdge, kEdge + 3), 0.8);
  EXPECT_DOUBLE_EQ(step.shareOf(1, 0, kEdge - 3), 1.0);  // what was no part of it keeps its label
  EXPECT_DOUBLE_EQ(step.shareOf(2, kEdge + 3, kCols), 1.0);
}

TEST(DissolveRegions, KeepsAThinFaceOfItsOwn) {
  Step step(kEdge - 2, kEdge + 2, 2.7);
  step.forEachPixel(kEdge - 2, kEdge + 2, [&](int i) { step.grid.range[i] -= static_cast<float>(kNear - 2.7); });
  const int before = countOf(step.labels, 3);
  EXPECT_EQ(step.left(), before);
}

TEST(DissolveRegions, KeepsAThinFaceThatTouchesNothing) {
  Step step(kEdge - 2, kEdge + 2, 0.5 * (kNear + kFar));
  for (std::int32_t& label : step.labels.labels) label = label == 3 ? 3 : 0;
  const int before = countOf(step.labels, 3);
  EXPECT_EQ(step.left(), before);
}

// Points of a face half way between two others are, one by one, nearer to either of those. With and without dropouts.
TEST(DissolveRegions, KeepsAWideFaceBetweenTwoOthers) {
  for (const int dropouts : {kRows, 3}) {
    Step step(kEdge - 12, kEdge + 12, 0.5 * (kNear + kFar));
    step.forEachPixel(kEdge - 12, kEdge, [&](int i) { step.grid.range[i] += static_cast<float>(0.5 * (kFar - kNear)); });
    step.forEachPixel(kEdge, kEdge + 12, [&](int i) { step.grid.range[i] -= static_cast<float>(0.5 * (kFar - kNear)); });
    for (int r = dropouts - 1; r < kRows; r += dropouts) {
      for (int i = step.grid.index(r, 0); i < step.grid.index(r, kCols); ++i) {
        step.grid.range[i] = kNoRange;
        step.labels.labels[i] = 0;
      }
    }
    const int before = countOf(step.labels, 3);
    EXPECT_EQ(step.left(200), before) << dropouts;
  }
}

// A square of the wall to the left stands off by so many standard deviations of the noise.
TEST(DissolveRegions, DissolvesBumpsWhereNoiseIsSmooth) {
  const auto pointsLeft = [](double sigmas, double growth, double share_given, double host_off = 0.0) {
    Step step(0, 0, kNear + sigmas * kSigma);
    step.planes[1] = Step::at(kNear + host_off * kSigma);
    const auto forEachOf = [&](const auto& f) {
      for (int r = 40; r < 56; ++r) {
        for (int c = 20; c < 36; ++c) f(step.grid.index(r, c));
      }
    };
    forEachOf([&](int i) {
      step.labels.labels[i] = 3;
      step.grid.range[i] += static_cast<float>(sigmas * kSigma);
    });
    CoplanarityTolerance tolerance = kTolerance;
    tolerance.inflation_growth = growth;
    const int left = step.left(kSmallest, tolerance);
    int given = 0;
    forEachOf([&](int i) { given += step.labels.labels[i] == 1 ? 1 : 0; });
    EXPECT_GE(given, share_given * 16 * 16);
    return left;
  };
  for (const double side : {-1.0, 1.0}) {
    EXPECT_EQ(pointsLeft(1.0 * side, 0.5, 0.8), 0);
    EXPECT_EQ(pointsLeft(1.0 * side, 0.0, 0.0), 16 * 16);
    EXPECT_EQ(pointsLeft(2.5 * side, 0.5, 0.0), 16 * 16);
    EXPECT_EQ(pointsLeft(2.5 * side, 0.5, 0.0, -3.0 * side), 16 * 16);  // a plane that fits badly is no reason
  }
}

// A face of its own, so far in front of the walls that these do not explain it; columns from kEdge on, rows below `end`.
int leftOfFace(int columns, int end, bool alone = false, int smallest = 40) {
  Step step(kEdge, kEdge + columns, 2.7);
  for (int i = 0; i < step.grid.size(); ++i) {
    std::int32_t& label = step.labels.labels[i];
    if (label == 3) step.grid.range[i] -= static_cast<float>(kFar - 2.7);
    if (label == 3 && i >= step.grid.index(end, 0)) label = 0;
    if (label != 3 && alone) label = 0;
  }
  const int before = countOf(step.labels, 3), left = step.left(smallest);
  EXPECT_TRUE(left == 0 || left == before);
  return left;
}

TEST(DissolveRegions, ALineIsNoFace) {
  EXPECT_EQ(leftOfFace(1, kRows), 0);
  EXPECT_EQ(leftOfFace(1, kRows, true), 0);  // though nothing is around
}

TEST(DissolveRegions, TwoLinesNeedMorePointsThanThree) {
  EXPECT_EQ(leftOfFace(2, kRows), 2 * (kRows - 5));
  EXPECT_EQ(leftOfFace(2, kRows, true), 2 * (kRows - 5));
  EXPECT_EQ(leftOfFace(2, 50, false, 60), 0);
  EXPECT_EQ(leftOfFace(2, 50, true, 60), 0);
  EXPECT_EQ(leftOfFace(3, 50), 3 * 45);
  EXPECT_EQ(leftOfFace(2, 50, false, 20), 2 * 45);  // by the smallest size
}

TEST(DissolveRegions, ALineBetweenLostLinesIsNoFace) {
  Step step(0, 0, kNear);
  for (int i = 0; i < step.grid.size(); ++i) {
    const int row = i / kCols;
    step.labels.labels[i] = row == 40 ? 3 : 0;
    if (row != 40 && std::abs(row - 40) < 3) step.grid.range[i] = kNoRange;
  }
  EXPECT_EQ(step.left(), 0);
}

// A strip that only another one explains, which itself goes to a wall: it stays, whichever has the lower label.
TEST(DissolveRegions, KeepsWhatOnlyADissolvedRegionExplains) {
  for (const bool first : {true, false}) {
    Step step(0, 0, kNear);
    const int strip = first ? 3 : 4, beside = first ? 4 : 3;
    step.planes.push_back(Step::at(kNear));
    step.planes[strip] = Step::at(kNear - 0.1);
    step.planes[beside] = Step::at(kNear + 0.02);  // nearer than that to the strip's points, as the wall is to its own
    for (int i = 0; i < step.grid.size(); ++i) {
      const int row = i / kCols, col = i % kCols;
      std::int32_t& label = step.labels.labels[i];
      if (col < kEdge) label = row >= 5 && col >= kEdge - 3 ? strip : 0;
      if (row >= 5 && col >= kEdge && col < kEdge + 3) label = beside;
    }
    const int points = countOf(step.labels, strip);
    step.left();
    EXPECT_EQ(countOf(step.labels, beside), 0) << first;
    EXPECT_EQ(countOf(step.labels, strip), points) << first;
  }
}

// Of either wall a line, and the plane through both. @param farther of the wall behind. @param sigmas what the lines stand
// off the walls.
int leftOfTwoLines(double farther, double sigmas, double share_given) {
  Step step(kEdge - 1, kEdge + 1, kNear);
  const double far = kFar + farther;
  for (int r = 0; r < kRows; ++r) {
    for (int c = kEdge; c < kCols; ++c) step.grid.range[step.grid.index(r, c)] += static_cast<float>(farther);
  }
  step.planes[2] = Step::at(far);
  const double off = sigmas * kSigma;
  step.forEachPixel(kEdge - 1, kEdge + 1, [&](int i) { step.grid.range[i] += static_cast<float>(off); });
  const auto across = [&](int col) {
    const Eigen::Vector3f u = step.grid.direction(step.grid.index(kRows / 2, col));
    return static_cast<double>(u.y() / u.x());
  };
  Eigen::Matrix2d through;
  through << kNear + off, (kNear + off) * across(kEdge - 1), far + off, (far + off) * across(kEdge);
  const Eigen::Vector2d a = through.inverse() * Eigen::Vector2d::Ones();
  step.planes[3] = {a.x(), a.y(), 0.0};
  const int left = step.left();
  EXPECT_GE(step.shareOf(1, kEdge - 1, kEdge), share_given);
  EXPECT_GE(step.shareOf(2, kEdge, kEdge + 1), share_given);
  return left;
}

TEST(DissolveRegions, TwoLinesOfTwoFacesAreNone) {
  EXPECT_EQ(leftOfTwoLines(0.5, 0.0, 0.95), 0);  // though their plane fits as well as the walls do
  EXPECT_EQ(leftOfTwoLines(0.0, 0.0, 0.7), 0);
  EXPECT_EQ(leftOfTwoLines(0.5, 1.5, 0.0), 2 * (kRows - 5));  // off the walls: a face
}

// Each is nearer to the other's plane than to its own, and nothing else is around.
TEST(DissolveRegions, KeepsRegionsThatExplainOnlyEachOther) {
  Step step(0, 0, kNear);
  std::fill(step.labels.labels.begin(), step.labels.labels.end(), 0);
  step.planes.push_back(Step::at(kFar));
  step.planes[3] = Step::at(kNear);
  step.forEachPixel(kEdge - 3, kEdge, [&](int i) { step.labels.labels[i] = 4; });
  step.forEachPixel(kEdge, kEdge + 3, [&](int i) { step.labels.labels[i] = 3; });
  EXPECT_EQ(step.left(), 3 * (kRows - 5));
  EXPECT_EQ(countOf(step.labels, 4), 3 * (kRows - 5));
}

TEST(DissolveRegions, LeavesLargeRegionsAlone) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  EXPECT_EQ(step.left(31), 510);
  EXPECT_EQ(step.left(32), 0);
}

TEST(DissolveRegions, LeavesWhatIsHardlyExplainedBetter) {
  for (const double off : {0.2, 0.6}) {
    Step step(kEdge - 3, kEdge + 3, kNear + off * kSigma);
    step.forEachPixel(kEdge, kEdge + 3, [&](int i) { step.grid.range[i] -= static_cast<float>(kFar - kNear); });
    std::replace(step.labels.labels.begin(), step.labels.labels.end(), 2, 1);
    const int before = countOf(step.labels, 3);
    EXPECT_EQ(step.left(), off < 0.4 ? before : 0) << off;
  }
}

TEST(DissolveRegions, GivesNothingToWhatIsDissolvedToo) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  step.planes.push_back(step.planes[3]);
  step.forEachPixel(kEdge, kEdge + 3, [&](int i) { step.labels.labels[i] = 4; });
  EXPECT_EQ(step.left(), 0);
  EXPECT_EQ(countOf(step.labels, 4), 0);
  EXPECT_GT(step.shareOf(1, kEdge - 3, kEdge), 0.9);
  EXPECT_GT(step.shareOf(2, kEdge, kEdge + 3), 0.9);
}

TEST(DissolveRegions, LeavesWhatIsNoRegion) {
  Step step(kEdge - 1, kEdge + 1, 0.5 * (kNear + kFar));
  for (int r = 5; r < kRows; ++r) {
    if (r < 50) continue;
    for (int c = kEdge - 1; c < kEdge + 1; ++c) step.labels.labels[step.grid.index(r, c)] = c < kEdge ? 1 : 2;
  }
  ASSERT_LT(countOf(step.labels, 3), kSmallest);
  const int before = countOf(step.labels, 3);
  EXPECT_EQ(step.left(), before);
}

TEST(DissolveRegions, IsNotExplainedByWhatIsNoRegion) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      std::int32_t& label = step.labels.labels[step.grid.index(r, c)];
      if (label == 2 && (r < 5 || c != kEdge + 3)) label = 0;  // a rest of it, too small
    }
  }
  ASSERT_LT(countOf(step.labels, 2), kSmallest);
  const int before = countOf(step.labels, 3);
  EXPECT_EQ(step.left(), before);
}

TEST(DissolveRegions, LeavesOutliersToNoRegion) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  const int outlier = step.grid.index(40, kEdge);
  step.grid.range[outlier] += 0.5F;
  EXPECT_EQ(step.left(), 0);
  EXPECT_EQ(step.labels.labels[outlier], 0);
}

TEST(DissolveRegions, PassesOverPixelsWithoutARange) {
  Step step(kEdge - 3, kEdge + 3, 0.5 * (kNear + kFar));
  for (int r = 0; r < kRows; r += 3) {
    for (int c = 0; c < kCols; ++c) step.grid.range[step.grid.index(r, c)] = kNoRange;
  }
  step.memory.place.assign(static_cast<std::size_t>(step.grid.size()), 1 << 30);  // of another image
  step.left();
  int kept = 0;
  for (int i = 0; i < step.grid.size(); ++i) kept += step.labels.labels[i] == 3 && step.grid.valid(i) ? 1 : 0;
  EXPECT_EQ(kept, 0);
}

TEST(DissolveRegions, LeavesAnImageWithoutRegionsAlone) {
  Step step(kEdge, kEdge, kNear);
  std::fill(step.labels.labels.begin(), step.labels.labels.end(), 0);
  step.left();
  EXPECT_EQ(countOf(step.labels, 0), step.grid.size());
}

}  // namespace
}  // namespace ppc
