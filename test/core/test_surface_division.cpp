// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_division.h"

#include "surface_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

// With the links of its cells.
struct Region : SurfaceRegion {
  SurfaceLinks links;

  explicit Region(const std::vector<Surface>& surfaces) : SurfaceRegion(surfaces, forwardBeams(80, 120, 0.0025)) {
    links.begin.push_back(0);
    for (int k = 0; k < static_cast<int>(surface.size()); ++k) {
      cells.forEachNeighbour(k, [&](int j) { links.cells.push_back(j); });
      links.begin.push_back(static_cast<int>(links.cells.size()));
    }
  }

  SurfaceDivision divide() const {
    DivisionMemory memory;
    SurfaceDivision first, again;
    divideSurface(surface, links, bestCut(surface, 100), 100, memory, first);
    divideSurface(surface, links, bestCut(surface, 100), 100, memory, again);  // with memory as left
    EXPECT_EQ(first.beyond, again.beyond);
    EXPECT_EQ(first.gain, again.gain);
    return first;
  }

  // The true label in the middle of cell k.
  std::int32_t trueLabel(std::size_t k) const {
    const Patch& cell = cells.patches[k];
    return truth.labels[grid.index((cell.row_begin + cell.row_end) / 2, (cell.col_begin + cell.col_end) / 2)];
  }
};

const auto kDoor = [](const Eigen::Vector3d& p) { return std::abs(p.y() + 0.1) < 0.12 && p.z() < 0.12; };
Region doorBehind(double depth) {
  return Region({surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0 - depth}, kDoor}),
                 surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, [](const Eigen::Vector3d& p) { return !kDoor(p); }})});
}

TEST(DivideSurface, FindsWhatNoCutParts) {
  for (const double depth : {0.015, -0.015}) {
    const Region region = doorBehind(depth);
    const SurfaceDivision division = region.divide();
    ASSERT_EQ(division.beyond.size(), region.surface.size());
    int wrong = 0;
    for (std::size_t k = 0; k < region.surface.size(); ++k) {
      wrong += (division.beyond[k] != 0) == (region.trueLabel(k) == 1) ? 1 : 0;
    }
    const int cells = static_cast<int>(region.surface.size());
    EXPECT_LT(std::min(wrong, cells - wrong), 0.05 * cells);
    EXPECT_GT(division.gain, 1.5 * bestCut(region.surface, 100).gain);
  }
}

TEST(DivideSurface, GainsWhatFitsOfBothSidesDoAndCountsItsBorder) {
  const Region region = doorBehind(0.02);
  const SurfaceDivision division = region.divide();
  ASSERT_FALSE(division.beyond.empty());
  Moments near, beyond;
  for (std::size_t k = 0; k < region.surface.size(); ++k) {
    (division.beyond[k] != 0 ? beyond : near) += region.cells.patches[k].moments;
  }
  const double gain = fitPlane(region.all).chi2 - fitPlane(near).chi2 - fitPlane(beyond).chi2;
  EXPECT_NEAR(division.gain, gain, 2e-3 * gain);
  int border = 0;
  for (int k = 0; k < static_cast<int>(region.surface.size()); ++k) {
    region.cells.forEachNeighbour(k, [&](int j) { border += k < j && division.beyond[j] != division.beyond[k] ? 1 : 0; });
  }
  EXPECT_EQ(division.border, border);
  EXPECT_NEAR(division.score(), division.gain - 3.0 * border, 1e-9);
}

TEST(DivideSurface, OfAPlaneExplainsNoNoise) {
  for (const double tilt : {0.0, 0.2, 0.5, 1.0}) {
    const SurfaceDivision division = Region({wall({-1.0, tilt, 0.1}, -3.0)}).divide();
    EXPECT_LT(division.beyond.empty() ? 0.0 : division.score(), 25.0);
  }
}

TEST(DivideSurface, KeepsAPatchApartOnlyIfItGainsByIt) {
  constexpr int kSide = 20;
  constexpr float kWeight = 25.0F;
  const auto door = [](int r, int c) { return r >= 5 && r < 13 && c >= 6 && c < 12; };
  const auto isApart = [&](float misfit) {  // one cell far from the door, four edges about it
    std::vector<SurfaceCell> cells;
    SurfaceLinks links;
    links.begin.push_back(0);
    for (int i = 0; i < kSide * kSide; ++i) {
      const int r = i / kSide, c = i % kSide;
      const float u = 0.1F * static_cast<float>(c - kSide / 2), v = 0.1F * static_cast<float>(r - kSide / 2);
      const float e = door(r, c) ? 1.0F : r == 16 && c == 16 ? misfit : 0.0F, w = kWeight;
      cells.push_back({static_cast<float>(c),
                       static_cast<float>(r),
                       {Lanes{16.0F, w, w * u, w * v}, Lanes{w * u * u, w * u * v, w * v * v, 0.0F},
                        Lanes{w * e, w * e * u, w * e * v, 0.0F}}});
      for (const auto& [dr, dc] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
        const bool inside = r + dr >= 0 && r + dr < kSide && c + dc >= 0 && c + dc < kSide;
        if (inside) links.cells.push_back(i + dr * kSide + dc);
      }
      links.begin.push_back(static_cast<int>(links.cells.size()));
    }
    DivisionMemory memory;
    SurfaceDivision division;
    divideSurface(cells, links, bestCut(cells, 100), 100, memory, division);
    EXPECT_EQ(division.beyond.size(), cells.size());
    EXPECT_NE(division.beyond[8 * kSide + 8], division.beyond[0]);
    return division.beyond[16 * kSide + 16] != division.beyond[0];
  };
  EXPECT_FALSE(isApart(0.0F));
  EXPECT_FALSE(isApart(0.9F));  // 20 in chi-square, less 12 for its edges
  EXPECT_TRUE(isApart(1.3F));
}

// Cells that link to no other take the nearer plane, and that is that.
TEST(DivideSurface, EndsThoughCellsLieByThemselves) {
  Region region = doorBehind(0.02);
  std::vector<SurfaceCell> cells = region.surface;
  const std::size_t linked = cells.size();
  for (std::size_t k = 0; k < linked; k += 5) {
    cells.push_back(region.surface[k]);
    region.links.begin.push_back(region.links.begin.back());
  }
  DivisionMemory memory;
  SurfaceDivision division;
  divideSurface(cells, region.links, bestCut(cells, 100), 100, memory, division);
  ASSERT_EQ(division.beyond.size(), cells.size());
  int apart = 0;
  for (std::size_t i = linked, k = 0; i < cells.size(); ++i, k += 5) {
    apart += division.beyond[i] != division.beyond[k] ? 1 : 0;
  }
  EXPECT_LT(apart, 0.2 * static_cast<double>(cells.size() - linked));
}

TEST(DivideSurface, LeavesFewPointsOnNeitherSide) {
  const Region region = doorBehind(0.02);
  DivisionMemory memory;
  SurfaceDivision division;
  const int half = region.grid.size() / 2;
  divideSurface(region.surface, region.links, bestCut(region.surface, 100), 100, memory, division);
  ASSERT_FALSE(division.beyond.empty());  // which the next ones have to clear
  divideSurface(region.surface, region.links, bestCut(region.surface, half + 1), half + 1, memory, division);
  EXPECT_TRUE(division.beyond.empty());
  EXPECT_EQ(division.gain, 0.0);
  divideSurface({}, {{0}, {}}, {}, 1.0, memory, division);
  EXPECT_TRUE(division.beyond.empty());
}

}  // namespace
}  // namespace ppc
