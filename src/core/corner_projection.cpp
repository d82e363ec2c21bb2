// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/corner_projection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

// How far the range of a corner may leave the ranges measured around it. Half a step of a usual scan changes the range by
// more only below 2 degrees of grazing, where the plane's own error decides where the beam meets it.
constexpr double kRangeFactor = 1.25;

// How far the corner of a diagonal touch moves into its own pixel, in pixels.
constexpr double kPull = 0.25;

}  // namespace

CornerProjection::CornerProjection(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region)
    : grid_(grid), labels_(labels), region_(region) {
  const Eigen::Vector3d& n = region.plane.normal;
  centre_ = region.centroid - region.plane.signedDistance(region.centroid) * n;
  axis_x_ = n.unitOrthogonal();
  axis_y_ = n.cross(axis_x_);
  shortest_ = longest_ = std::max(1e-3, region.centroid.norm());
}

CornerProjection::Cut CornerProjection::cut(double row, double col) {
  const int r0 = std::clamp(static_cast<int>(std::floor(row)), 0, std::max(0, grid_.rows - 2));
  const int c0 = std::clamp(static_cast<int>(std::floor(col)), 0, std::max(0, grid_.cols - 2));
  const int r1 = std::min(r0 + 1, grid_.rows - 1);
  const int c1 = std::min(c0 + 1, grid_.cols - 1);
  const int pixels[4] = {grid_.index(r0, c0), grid_.index(r0, c1), grid_.index(r1, c0), grid_.index(r1, c1)};
  const double fr = row - r0, fc = col - c0;  // -0.5 and 1.5 at the border: the same expression extrapolates

  double shortest = INFINITY, longest = 0.0;
  for (const int i : pixels) {
    if (labels_.labels[i] != region_.id || !grid_.valid(i)) continue;
    shortest = std::min<double>(shortest, grid_.range[i]);
    longest = std::max<double>(longest, grid_.range[i]);
  }
  if (longest > 0.0) {
    shortest_ = shortest;
    longest_ = longest;
  }

  const auto interpolate = [&](const auto& at, Eigen::Vector3d& value, Eigen::Vector3d& per_row, Eigen::Vector3d& per_col) {
    const Eigen::Vector3d v00 = at(pixels[0]), v01 = at(pixels[1]), v10 = at(pixels[2]), v11 = at(pixels[3]);
    const Eigen::Vector3d upper = v00 + fc * (v01 - v00);
    const Eigen::Vector3d lower = v10 + fc * (v11 - v10);
    per_row = lower - upper;
    per_col = (v01 - v00) + fr * ((v11 - v10) - (v01 - v00));
    value = upper + fr * per_row;
  };
  Cut c;
  interpolate([&](int i) -> Eigen::Vector3d { return grid_.direction(i).cast<double>(); }, c.direction, c.row_change,
              c.col_change);
  const double length = std::max(1e-6, c.direction.norm());
  const double least = shortest_ / kRangeFactor / length, most = longest_ * kRangeFactor / length;
  Eigen::Vector3d origin_per_row = Eigen::Vector3d::Zero(), origin_per_col = Eigen::Vector3d::Zero();
  c.origin.setZero();
  if (!grid_.origin_x.empty()) {
    interpolate([&](int i) -> Eigen::Vector3d { return grid_.origin(i).cast<double>(); }, c.origin, origin_per_row,
                origin_per_col);
  }
  const Eigen::Vector3d& n = region_.plane.normal;
  c.incidence = n.dot(c.direction);
  const double t = region_.plane.rangeAlong(c.origin, c.direction);
  c.clamped = !(least <= t && t <= most);
  c.range = !c.clamped ? t : (t > 0.0 && t < least ? least : most);  // a beam that misses the plane meets it at infinity
  c.row_change = origin_per_row + c.range * c.row_change;
  c.col_change = origin_per_col + c.range * c.col_change;
  return c;
}

OutlinePoint CornerProjection::project(const PixelCorner& corner) {
  const Cut c = cut(corner.row - 0.5 + kPull * corner.pull_row, corner.col - 0.5 + kPull * corner.pull_col);
  const Eigen::Vector3d p = c.origin + c.range * c.direction - centre_;
  const auto flatten = [&](const Eigen::Vector3d& v) { return Eigen::Vector2d(axis_x_.dot(v), axis_y_.dot(v)); };
  OutlinePoint out;
  out.point = flatten(p);
  out.row_step = flatten(c.row_change);
  out.col_step = flatten(c.col_change);
  if (!c.clamped) {  // the range changes with the step, so that the point stays on the plane
    const Eigen::Vector2d along = flatten(c.direction) / c.incidence;
    out.row_step -= region_.plane.normal.dot(c.row_change) * along;
    out.col_step -= region_.plane.normal.dot(c.col_change) * along;
  }
  return out;
}

int CornerProjection::handedness(int row, int col) const {
  const int r0 = std::clamp(row - 1, 0, std::max(0, grid_.rows - 2)), r1 = std::min(r0 + 1, grid_.rows - 1);
  const int c0 = std::clamp(col - 1, 0, std::max(0, grid_.cols - 2)), c1 = std::min(c0 + 1, grid_.cols - 1);
  const int i00 = grid_.index(r0, c0), i01 = grid_.index(r0, c1), i10 = grid_.index(r1, c0), i11 = grid_.index(r1, c1);
  const Eigen::Vector3f u = grid_.direction(i00);
  Eigen::Vector3f per_row = (grid_.direction(i10) - u) + (grid_.direction(i11) - grid_.direction(i01));
  Eigen::Vector3f per_col = (grid_.direction(i01) - u) + (grid_.direction(i11) - grid_.direction(i10));
  if (!grid_.origin_x.empty()) {  // what moves the point is the origin and, at its range, the direction
    const double range = region_.plane.rangeAlong(grid_.origin(i00).cast<double>(), u.cast<double>());
    const auto t = static_cast<float>(range > 0.0 ? std::min(range, 1e3) : 1e3);
    per_row += ((grid_.origin(i10) - grid_.origin(i00)) + (grid_.origin(i11) - grid_.origin(i01))) / t;
    per_col += ((grid_.origin(i01) - grid_.origin(i00)) + (grid_.origin(i11) - grid_.origin(i10))) / t;
  }
  const float area = u.dot(per_col.cross(per_row));
  const float tiny = 1e-6F * per_col.norm();  // rounding of the directions
  return area > tiny ? 1 : (area < -tiny ? -1 : 0);
}

}  // namespace ppc
