// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_cut.h"

#include "surface_region.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace ppc {
namespace {

using namespace testing_tools;

struct Region : SurfaceRegion {
  explicit Region(const std::vector<Surface>& surfaces, const BeamGrid& beams = forwardBeams(40, 60, 0.005))
      : SurfaceRegion(surfaces, beams) {}

  // Chi-square of one plane less that of two, by fits; 0 if a side is too small.
  double gainOf(const SurfaceCut& cut, int fewest) const {
    Moments below, beyond;
    for (std::size_t k = 0; k < surface.size(); ++k) {
      (cut.isBeyond(surface[k]) ? beyond : below) += cells.patches[k].moments;
    }
    if (below.n < fewest || beyond.n < fewest) return 0.0;
    return fitPlane(all).chi2 - fitPlane(below).chi2 - fitPlane(beyond).chi2;
  }
};

// A wall whose left part is turned towards the sensor.
Region bentWall(double turn, double y) {
  const Eigen::Vector3d normal(-std::cos(turn), std::sin(turn), 0.0);
  return Region(
      {surfaceOf({{normal, normal.dot(Eigen::Vector3d(3.0, y, 0.0))}, [=](const Eigen::Vector3d& p) { return p.y() > y; }}),
       surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, [=](const Eigen::Vector3d& p) { return p.y() <= y; }})});
}

TEST(SurfaceCut, IsTheBestOfAllCutsByFitsOfBothSides) {
  for (const double y : {0.0, 0.25, -0.2}) {
    const Region region = bentWall(0.3, y);
    const SurfaceCut cut = bestCut(region.surface, 100);
    EXPECT_NEAR(cut.gain, region.gainOf(cut, 100), 1e-3 * cut.gain);
    double best = 0.0;
    for (int direction = 0; direction < 8; ++direction) {
      const auto angle = static_cast<float>(M_PI * direction / 8.0);
      SurfaceCut plain{0.0, std::cos(angle), std::sin(angle), 0.0F};
      float first = 1e9F, last = -1e9F;
      for (const SurfaceCell& cell : region.surface) {
        first = std::min(first, plain.across_x * cell.x + plain.across_y * cell.y);
        last = std::max(last, plain.across_x * cell.x + plain.across_y * cell.y);
      }
      for (int k = 1; k < 16; ++k) {
        plain.at = first + static_cast<float>(k) * (last - first) / 16.0F;
        best = std::max(best, region.gainOf(plain, 100));
      }
    }
    EXPECT_NEAR(cut.gain, best, 1e-3 * best);
    EXPECT_GT(cut.gain, bowGain(region.surface) + 100.0);
  }
}

// Two strips on both sides of an upright crease, seen so far up and down that it is bent in the image.
Region bentStrips() {
  const double turn = 0.3;
  const Eigen::Vector3d normal(-std::cos(turn), std::sin(turn), 0.0), crease(1.0, 0.6, 0.0);
  return Region(
      {surfaceOf({{normal, normal.dot(crease)}, [](const Eigen::Vector3d& p) { return p.y() > 0.6 && p.y() < 0.75; }}),
       surfaceOf(
           {{-Eigen::Vector3d::UnitX(), -1.0}, [](const Eigen::Vector3d& p) { return p.y() > 0.45 && p.y() <= 0.6; }})},
      forwardBeams(200, 240, 0.01));
}

TEST(SurfaceCut, OnThePlaneFollowsACreaseThatIsBentInTheImage) {
  const Region region = bentStrips();
  const SurfaceCut cut = bestCutOnPlane(region.surface, 100);
  EXPECT_NEAR(cut.gain, region.gainOf(cut, 100), 1e-3 * cut.gain);
  EXPECT_GT(cut.gain, 1.2 * bestCut(region.surface, 100).gain);
  std::array<int, 2> beyond = {0, 0}, all = {0, 0};  // cells of each strip
  for (std::size_t k = 0; k < region.surface.size(); ++k) {
    const Patch& cell = region.cells.patches[k];
    const std::int32_t strip = region.truth.labels[region.grid.index(cell.row_begin, cell.col_begin)];
    if (strip == 0 || region.truth.labels[region.grid.index(cell.row_end - 1, cell.col_end - 1)] != strip) continue;
    ++all[strip - 1];
    beyond[strip - 1] += cut.isBeyond(region.surface[k]) ? 1 : 0;
  }
  EXPECT_GT(std::min(all[0], all[1]), 30);
  EXPECT_GT(std::abs(static_cast<double>(beyond[0]) / all[0] - static_cast<double>(beyond[1]) / all[1]), 0.95);
}

TEST(SurfaceCut, OfAPlaneGainsNoMoreThanNoise) {
  const Region region({wall({-1.0, 0.2, 0.1}, -3.0)});
  EXPECT_LT(bestCut(region.surface, 100).gain, 25.0);
  EXPECT_LT(bestCutOnPlane(region.surface, 100).gain, 25.0);
  EXPECT_LT(bowGain(region.surface), 20.0);
}

TEST(SurfaceCut, LeavesFewPointsOnNeitherSide) {
  const Region region = bentWall(0.3, 0.25);
  EXPECT_EQ(bestCut(region.surface, 1201).gain, 0.0);
  const SurfaceCut cut = bestCut(region.surface, 1000);
  EXPECT_GT(region.gainOf(cut, 1000), 0.0);
  EXPECT_EQ(bestCut({}, 0).gain, 0.0);
  EXPECT_EQ(bestCutOnPlane(region.surface, 1201).gain, 0.0);
  EXPECT_EQ(bestCutOnPlane({}, 0).gain, 0.0);
}

TEST(SurfaceCut, AColumnIsBowedRatherThanCut) {
  const Region region({column(4.0, 0.0, 1.0)});
  EXPECT_GT(bowGain(region.surface), bestCut(region.surface, 100).gain);
}

TEST(BowGain, IsThatOfAFitToThePoints) {
  const Region region({column(4.0, 0.2, 1.0)});
  const Eigen::Vector3d a = fitPlane(region.all).a, mean = region.all.mean();
  const Eigen::Vector3d u = a.unitOrthogonal(), v = a.normalized().cross(u);
  Eigen::MatrixXd rows(region.grid.size(), 6);
  Eigen::VectorXd misfits(region.grid.size());
  for (const Patch& cell : region.cells.patches) {
    const Eigen::Vector3d at = cell.moments.mean() - mean;
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int c = cell.col_begin; c < cell.col_end; ++c) {
        const int i = region.grid.index(r, c);
        const Eigen::Vector3d p = region.grid.point(i).cast<double>() - region.cells.center;
        const double weight = region.grid.range[i] / 0.01;
        rows.row(i) << p.transpose(), at.dot(u) * at.dot(u), at.dot(u) * at.dot(v), at.dot(v) * at.dot(v);
        rows.row(i) *= weight;
        misfits[i] = weight * (1.0 - a.dot(p));
      }
    }
  }
  const Eigen::VectorXd solved = rows.colPivHouseholderQr().solve(misfits);
  const double gain = misfits.squaredNorm() - (misfits - rows * solved).squaredNorm();
  EXPECT_NEAR(bowGain(region.surface), gain, 0.02 * gain);
}

}  // namespace
}  // namespace ppc
