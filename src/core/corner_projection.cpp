// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/corner_projection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {
namespace {

// How far the range of a corner may leave the ranges measured around it. Half a step of a usual scan changes the range by
// more only below 2 degrees of grazing, where the plane's own error decides where the beam meets it.
constexpr double kRangeFactor = 1.25;

// How far the corner of a diagonal touch moves into its own pixel, in pixels.
constexpr double kPull = 0.25;

// One coordinate between four pixels (row by row), and how it changes from row to row and from column to column there.
inline void interpolate(const float* values, const int (&pixels)[4], double fr, double fc, double& value, double& per_row,
                        double& per_col) {
  const double v00 = values[pixels[0]], v01 = values[pixels[1]], v10 = values[pixels[2]], v11 = values[pixels[3]];
  const double upper_step = v01 - v00, lower_step = v11 - v10;
  const double upper = v00 + fc * upper_step;
  const double lower = v10 + fc * lower_step;
  per_row = lower - upper;
  per_col = upper_step + fr * (lower_step - upper_step);
  value = upper + fr * per_row;
}

}  // namespace

CornerProjection::CornerProjection(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region)
    : grid_(grid),
      labels_(labels),
      region_(region),
      directions_{grid.dir_x.data(), grid.dir_y.data(), grid.dir_z.data()},
      origins_{grid.origin_x.data(), grid.origin_y.data(), grid.origin_z.data()} {
  const Eigen::Vector3d& n = region.plane.normal;
  centre_ = region.centroid - region.plane.signedDistance(region.centroid) * n;
  axis_x_ = n.unitOrthogonal();
  axis_y_ = n.cross(axis_x_);
  shortest_ = longest_ = std::max(1e-3, region.centroid.norm());
}

CornerProjection::Cut CornerProjection::cut(const PixelCorner& corner) {
  // The corner lies half a pixel before its pixel's centre, or a little off if it is pulled.
  const int r0 = std::clamp(corner.row - 1, 0, std::max(0, grid_.rows - 2));
  const int c0 = std::clamp(corner.col - 1, 0, std::max(0, grid_.cols - 2));
  const int r1 = std::min(r0 + 1, grid_.rows - 1);
  const int c1 = std::min(c0 + 1, grid_.cols - 1);
  const int pixels[4] = {grid_.index(r0, c0), grid_.index(r0, c1), grid_.index(r1, c0), grid_.index(r1, c1)};
  // -0.5 and 1.5 at the border: the same expression extrapolates.
  const double fr = corner.row - 0.5 + kPull * corner.pull_row - r0, fc = corner.col - 0.5 + kPull * corner.pull_col - c0;
  measureAround(pixels);

  Cut c;
  for (int k = 0; k < 3; ++k) {
    interpolate(directions_[k], pixels, fr, fc, c.direction[k], c.row_change[k], c.col_change[k]);
  }
  const double length = std::max(1e-6, c.direction.norm());
  const double least = shortest_ / kRangeFactor / length, most = longest_ * kRangeFactor / length;
  Eigen::Vector3d origin_per_row = Eigen::Vector3d::Zero(), origin_per_col = Eigen::Vector3d::Zero();
  c.origin.setZero();
  if (!grid_.origin_x.empty()) {
    for (int k = 0; k < 3; ++k) {
      interpolate(origins_[k], pixels, fr, fc, c.origin[k], origin_per_row[k], origin_per_col[k]);
    }
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

// Limits of the range, from those of the four pixels that are the region's own.
void CornerProjection::measureAround(const int (&pixels)[4]) {
  float shortest = std::numeric_limits<float>::infinity(), longest = 0.0F;
  for (const int i : pixels) {
    const float range = grid_.range[static_cast<std::size_t>(i)];
    const bool own = (labels_.labels[static_cast<std::size_t>(i)] == region_.id) & (range > 0.0F);
    shortest = own && range < shortest ? range : shortest;
    longest = own && range > longest ? range : longest;
  }
  if (longest > 0.0F) {
    shortest_ = shortest;
    longest_ = longest;
  }
}

OutlinePoint CornerProjection::project(const PixelCorner& corner) {
  const Cut c = cut(corner);
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
  limited_ += c.clamped ? 1 : 0;
  return out;
}

Eigen::Vector2d CornerProjection::flatten(int row, int col) const {
  const Eigen::Vector3d p = grid_.point(grid_.index(row, col)).cast<double>() - centre_;
  return {axis_x_.dot(p), axis_y_.dot(p)};
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
