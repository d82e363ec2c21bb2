// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_cut.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kDirections = 8, kBins = 16;  // half the directions miss faces, half as many bins again find no others
constexpr float kRidge = 1e-6F;             // of a side's scatter: cells in one line tell nothing of the slope across it

// What a plane of its own takes off the chi-square of one side: its misfits regressed on 1, u and v.
float gainOf(const SurfaceSums& side) {
  const float w = side.places[1], u = side.places[2], v = side.places[3];
  const float mean = side.misfits[0] / w, ridge = kRidge * (side.squares[0] + side.squares[2]);
  const float uu = side.squares[0] - u * u / w + ridge, uv = side.squares[1] - u * v / w,
              vv = side.squares[2] - v * v / w + ridge;
  const float eu = side.misfits[1] - mean * u, ev = side.misfits[2] - mean * v;
  const float determinant = uu * vv - uv * uv;
  const float turned = determinant > 0.0F ? (vv * eu * eu - 2.0F * uv * eu * ev + uu * ev * ev) / determinant : 0.0F;
  return side.misfits[0] * mean + turned;
}

float angleOf(int direction) { return static_cast<float>(M_PI) * static_cast<float>(direction) / kDirections; }

// Keeps the best of the cuts that are tried.
class Cutter {
 public:
  Cutter(const std::vector<SurfaceCell>& cells, double fewest, bool on_plane)
      : cells_(cells), least_(static_cast<float>(fewest)) {
    cut_.on_plane = best_.on_plane = on_plane;
    for (const SurfaceCell& cell : cells) all_ += cell.sums;
  }

  // In 15 places.
  void cutAcross(float x, float y) {
    if (cells_.empty() || all_.points() < 2.0F * least_) return;
    cut_.across_x = x;
    cut_.across_y = y;
    float first = cut_.placeOf(cells_[0]), last = first;
    for (const SurfaceCell& cell : cells_) {
      first = std::min(first, cut_.placeOf(cell));
      last = std::max(last, cut_.placeOf(cell));
    }
    if (!(last > first)) return;
    const float width = (last - first) / kBins, scale = 1.0F / width;
    std::array<SurfaceSums, kBins + 1> bins = {};  // the last cell lies beyond the last cut
    for (const SurfaceCell& cell : cells_) {
      bins[static_cast<std::size_t>((cut_.placeOf(cell) - first) * scale)] += cell.sums;
    }
    SurfaceSums below, beyond = all_;
    for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
      if (bins[bin].points() == 0.0F) continue;
      below += bins[bin];
      beyond -= bins[bin];
      if (below.points() < least_) continue;
      if (beyond.points() < least_) break;
      cut_.gain = gainOf(below) + gainOf(beyond);
      cut_.at = first + static_cast<float>(bin + 1) * width;
      if (cut_.gain > best_.gain) best_ = cut_;
    }
  }

  const SurfaceCut& best() const { return best_; }

 private:
  const std::vector<SurfaceCell>& cells_;
  float least_;
  SurfaceSums all_;
  SurfaceCut cut_, best_;
};

}  // namespace

SurfaceFrame::SurfaceFrame(const Moments& sum, const PlaneFit& fit) : a_(fit.a) {
  const double scale = 1.0 / std::max(1e-6, sum.radius());
  const Eigen::Vector3d normal = fit.normal(), u = scale * normal.unitOrthogonal(), v = normal.cross(u), mean = sum.mean();
  u_ = u - u.dot(mean) * a_;
  v_ = v - v.dot(mean) * a_;
}

SurfaceSums SurfaceFrame::measure(const Moments& m) const {
  const auto times = [&](const Eigen::Vector3d& d) {
    return Eigen::Vector3d(m.xx * d.x() + m.xy * d.y() + m.xz * d.z(), m.xy * d.x() + m.yy * d.y() + m.yz * d.z(),
                           m.xz * d.x() + m.yz * d.y() + m.zz * d.z());
  };
  const auto dot = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) { return static_cast<float>(p.dot(q)); };
  const Eigen::Vector3d along = times(a_), along_u = times(u_), along_v = times(v_);
  const Eigen::Vector3d misfit = Eigen::Vector3d(m.x, m.y, m.z) - along;
  SurfaceSums sums;
  sums.places = Lanes{static_cast<float>(m.n), dot(a_, along), dot(u_, along), dot(v_, along)};
  sums.squares = Lanes{dot(u_, along_u), dot(u_, along_v), dot(v_, along_v), 0.0F};
  sums.misfits = Lanes{dot(a_, misfit), dot(u_, misfit), dot(v_, misfit), 0.0F};
  return sums;
}

SurfaceCut bestCut(const std::vector<SurfaceCell>& cells, double fewest) {
  Cutter cutter(cells, fewest, false);
  for (int k = 0; k < kDirections; ++k) cutter.cutAcross(std::cos(angleOf(k)), std::sin(angleOf(k)));
  return cutter.best();
}

SurfaceCut bestCutOnPlane(const std::vector<SurfaceCell>& cells, double fewest) {
  float n = 0.0F, u = 0.0F, v = 0.0F, uu = 0.0F, uv = 0.0F, vv = 0.0F;
  for (const SurfaceCell& cell : cells) {
    const float points = cell.sums.points(), at_u = cell.sums.u(), at_v = cell.sums.v();
    n += points;
    u += points * at_u;
    v += points * at_v;
    uu += points * at_u * at_u;
    uv += points * at_u * at_v;
    vv += points * at_v * at_v;
  }
  // By the Cholesky factor of the scatter.
  const float along = std::sqrt(uu - u * u / n), shear = (uv - u * v / n) / along;
  const float across = std::sqrt(vv - v * v / n - shear * shear);
  if (!(along > 0.0F && across > 0.0F)) return SurfaceCut();
  Cutter cutter(cells, fewest, true);
  for (int k = 0; k < kDirections; ++k) {
    const float round_v = std::sin(angleOf(k)) / across;
    cutter.cutAcross((std::cos(angleOf(k)) - shear * round_v) / along, round_v);
  }
  return cutter.best();
}

double bowGain(const std::vector<SurfaceCell>& cells) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 right = Vector6::Zero();
  for (const SurfaceCell& cell : cells) {
    const Lanes &places = cell.sums.places, &squares = cell.sums.squares, &misfits = cell.sums.misfits;
    if (!(places[1] > 0.0F)) continue;
    const double w = places[1], u = places[2] / w, v = places[3] / w;
    const Eigen::Vector3d linear(w, places[2], places[3]), quadratic(u * u, u * v, v * v);
    Eigen::Matrix3d plane;
    plane << w, places[2], places[3], places[2], squares[0], squares[1], places[3], squares[1], squares[2];
    normal.topLeftCorner<3, 3>() += plane;
    normal.bottomLeftCorner<3, 3>() += quadratic * linear.transpose();
    normal.bottomRightCorner<3, 3>() += w * quadratic * quadratic.transpose();
    right.head<3>() += Eigen::Vector3d(misfits[0], misfits[1], misfits[2]);
    right.tail<3>() += misfits[0] * quadratic;
  }
  return right.dot(normal.selfadjointView<Eigen::Lower>().ldlt().solve(right));
}

}  // namespace ppc
