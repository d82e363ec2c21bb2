// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_fringe.h"

#include "analytic_scenes.h"
#include "naive_beam_fit.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace ppc {
namespace {

using namespace testing_tools;

constexpr double kSigma = 0.02;
const Plane kWall{Eigen::Vector3d(-1.0, 0.2, 0.1).normalized(), -2.5};
const ErrorScale kScale{2.5 * kSigma, 0.02};

BeamGrid wallSeenBy(int rows, int cols) {
  BeamGrid grid = toBeamGrid(noddingScan(rows, cols, -8 * kDegree, 8 * kDegree, 12 * kDegree, {0.05, 0.0, 0.02}));
  scanFaces({{kWall, [](const Eigen::Vector3d&) { return true; }}}, grid);
  addNoise(grid, kSigma);
  return grid;
}

// Blocks as describeRegions() has them: stretches that go on over the ends of rows, cut at some length.
std::vector<PixelStretch> blocksOf(const LabelImage& labels, std::int32_t label, int length) {
  std::vector<PixelStretch> blocks;
  for (int i = 0; i < static_cast<int>(labels.labels.size()); ++i) {
    if (labels.labels[i] != label) continue;
    if (!blocks.empty() && blocks.back().end == i && i - blocks.back().begin < length) {
      ++blocks.back().end;
    } else {
      blocks.push_back({i, i + 1});
    }
  }
  return blocks;
}

std::set<int> pixelsIn(const std::vector<PixelStretch>& stretches) {
  std::set<int> pixels;
  for (const PixelStretch& stretch : stretches) {
    for (int i = stretch.begin; i < stretch.end; ++i) EXPECT_TRUE(pixels.insert(i).second) << i;
  }
  return pixels;
}

std::set<int> offOf(const BeamGrid& grid, const LabelImage& labels, FringeMemory& memory, int length = 256) {
  const std::vector<PixelStretch> blocks = blocksOf(labels, 1, length);
  Fringe fringe(grid, blocks.data(), blocks.data() + blocks.size(), memory);
  return pixelsIn(fringe.off({{kWall, kSigma}}, kScale));
}

// Each side's pixels from the image itself, in scan order.
std::vector<std::vector<int>> naiveSides(const BeamGrid& grid, const LabelImage& labels) {
  std::vector<std::vector<int>> sides;
  const int steps[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (const auto& step : steps) {
    std::vector<int>& side = sides.emplace_back();
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 0; c < grid.cols; ++c) {
        const int row = r + step[0], col = c + step[1];
        const bool inside = row >= 0 && row < grid.rows && col >= 0 && col < grid.cols;
        if (labels.labels[grid.index(r, c)] == 1 && !(inside && labels.labels[grid.index(row, col)] == 1)) {
          side.push_back(grid.index(r, c));
        }
      }
    }
  }
  return sides;
}

// In parts of at most 16, as equal as can be.
std::set<int> naiveOff(const BeamGrid& grid, const LabelImage& labels) {
  std::set<int> off;
  for (const std::vector<int>& side : naiveSides(grid, labels)) {
    const std::size_t parts = (side.size() + 15) / 16;
    for (std::size_t k = 0; k < parts; ++k) {
      double sum = 0.0, count = 0.0;
      const std::size_t first = side.size() * k / parts, last = side.size() * (k + 1) / parts;
      for (std::size_t j = first; j < last; ++j) {
        if (!grid.valid(side[j])) continue;
        ++count;
        const NaiveTerm term = naiveTerm(grid, side[j], kWall, kScale.softness);
        sum += std::clamp(term.h * std::sqrt(term.w), -kScale.limit, kScale.limit);
      }
      if (std::abs(sum) > 3.0 * kSigma * std::sqrt(count)) {
        off.insert(side.begin() + static_cast<std::ptrdiff_t>(first), side.begin() + static_cast<std::ptrdiff_t>(last));
      }
    }
  }
  return off;
}

// Spots and strips with holes, at the ends of rows too, of which some parts were moved; pixels without a measurement.
TEST(RegionFringe, AgreesWithTheImagePixelByPixel) {
  FringeMemory memory;
  int found = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    BeamGrid grid = wallSeenBy(5 + below(20), 5 + below(40));
    LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
    for (int k = 0; k < 12; ++k) {
      const int r0 = below(grid.rows), c0 = below(grid.cols), rows = 1 + below(8), cols = 1 + below(25),
                label = below(3) > 0;
      const float moved = below(2) == 0 ? 0.0F : 0.03F * static_cast<float>(below(3) - 1);
      for (int r = r0; r < std::min(grid.rows, r0 + rows); ++r) {
        for (int c = c0; c < std::min(grid.cols, c0 + cols); ++c) {
          labels.labels[grid.index(r, c)] = label;
          grid.range[grid.index(r, c)] += moved;
        }
      }
    }
    for (int k = 0; k < 10; ++k) grid.range[below(grid.size())] = std::numeric_limits<float>::quiet_NaN();
    const std::set<int> expected = naiveOff(grid, labels);
    EXPECT_EQ(offOf(grid, labels, memory), expected) << seed;
    EXPECT_EQ(offOf(grid, labels, memory, 7), expected) << seed;
    std::set<int> all;
    for (const std::vector<int>& side : naiveSides(grid, labels)) all.insert(side.begin(), side.end());
    const std::vector<PixelStretch> blocks = blocksOf(labels, 1, 256);
    EXPECT_EQ(pixelsIn(Fringe(grid, blocks.data(), blocks.data() + blocks.size(), memory).all()), all) << seed;
    found += expected.empty() ? 0 : 1;
  }
  EXPECT_GT(found, 20);
}

// One row too many, whose points are one and a half times the noise off: each of them looks like any other.
TEST(RegionFringe, ARowTooManyIsFoundAndNothingElse) {
  FringeMemory memory;
  BeamGrid grid = wallSeenBy(8, 160);
  LabelImage labels{8, 160, std::vector<std::int32_t>(8 * 160, 0)};
  std::fill(labels.labels.begin() + 160, labels.labels.begin() + 7 * 160, 1);
  EXPECT_LT(offOf(grid, labels, memory).size(), 20U);
  for (int i = 160; i < 320; ++i) grid.range[i] += static_cast<float>(1.5 * kSigma);
  const std::set<int> off = offOf(grid, labels, memory);
  ASSERT_GT(off.size(), 140U);
  EXPECT_LT(off.size(), 180U);
  EXPECT_LT(*std::next(off.begin(), 130), 320);
}

// A wall whose first row is 6 mm before it, seen at a slant.
BeamGrid steppedWall(const Plane& wall) {
  BeamGrid grid = toBeamGrid(noddingScan(8, 160, -2 * kDegree, 2 * kDegree, 5 * kDegree));
  scanFaces({{wall, [](const Eigen::Vector3d&) { return true; }}}, grid);
  for (int i = 0; i < 160; ++i) {
    const double cosine = std::abs(wall.normal.dot(grid.direction(i).cast<double>()));
    grid.range[i] -= static_cast<float>(0.006 / cosine);
  }
  return grid;
}

// The row is many standard deviations of its parts' means off: not for a judge that tolerates 5 mm, nor for one whose plane
// is known to 5 mm there, and for one of two judges it is. Also if points are missing.
TEST(RegionFringe, JudgesTolerateBowsAndWhatTheirPlanesAreNotKnown) {
  FringeMemory memory;
  const LabelImage labels{8, 160, std::vector<std::int32_t>(8 * 160, 1)};
  for (const double slant : {0.0, 60 * kDegree, 75 * kDegree}) {
    const Plane wall{Eigen::Vector3d(-std::cos(slant), std::sin(slant), 0.0), -2.0 * std::cos(slant)};
    for (const bool gaps : {false, true}) {
      BeamGrid grid = steppedWall(wall);
      for (int i = 0; gaps && i < grid.size(); ++i) {
        if (i % 16 > 4) grid.range[i] = std::numeric_limits<float>::quiet_NaN();  // the middle of each part, too
      }
      FringeJudge strict{wall, 0.002}, tolerant = strict, known_there = strict, unknown_there = strict;
      tolerant.tolerance = 0.005;
      // Of planes that turn about a line: one through the row, of which the distance does not change, and one far from it.
      const Eigen::Vector3d there = grid.point(68).cast<double>(), turned = 0.005 * wall.normal.unitOrthogonal();
      const auto turning = [&](const Eigen::Vector3d& through) {
        Eigen::Vector4d change;
        change << turned, turned.dot(through);
        return Eigen::Matrix4d(change * change.transpose());
      };
      known_there.covariance = turning(there);
      unknown_there.covariance = turning(there + 1.2 * wall.normal.unitOrthogonal());
      const std::vector<PixelStretch> blocks = blocksOf(labels, 1, 256);
      Fringe fringe(grid, blocks.data(), blocks.data() + blocks.size(), memory);
      const std::set<int> all = pixelsIn(fringe.off({strict}, kScale));
      EXPECT_GE(all.size(), 160U) << slant << ' ' << gaps;
      EXPECT_TRUE(fringe.off({tolerant}, kScale).empty()) << slant << ' ' << gaps;
      EXPECT_TRUE(fringe.off({unknown_there}, kScale).empty()) << slant << ' ' << gaps;
      EXPECT_FALSE(fringe.off({known_there}, kScale).empty()) << slant << ' ' << gaps;
      EXPECT_EQ(pixelsIn(fringe.off({tolerant, strict}, kScale)), all);
    }
  }
}

TEST(RegionFringe, NothingIsOffInNoRegionAndWithoutNoise) {
  FringeMemory memory;
  BeamGrid grid = wallSeenBy(4, 20);
  Fringe none(grid, nullptr, nullptr, memory);
  EXPECT_TRUE(none.all().empty());
  EXPECT_TRUE(none.off({{kWall, kSigma}}, kScale).empty());
  scanFaces({{kWall, [](const Eigen::Vector3d&) { return true; }}}, grid);
  EXPECT_TRUE(offOf(grid, {4, 20, std::vector<std::int32_t>(80, 1)}, memory).empty());
}

}  // namespace
}  // namespace ppc
