// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/corner_projection.h"

#include "patch_plane_clustering/core/lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ppc {
namespace {

// How far the range of a corner may leave the ranges measured around it. Half a step of a usual scan changes the range by
// more only below 2 degrees of grazing, where the plane's own error decides where the beam meets it.
constexpr double kRangeFactor = 1.25;

// How far the corner of a diagonal touch moves into its own pixel, in pixels.
constexpr double kPull = 0.25;

// Three coordinates of two corners.
struct PairVector {
  Pair x, y, z;

  Pair dot(const Eigen::Vector3d& v) const { return v.x() * x + v.y() * y + v.z() * z; }
};

PairVector operator+(const PairVector& a, const PairVector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
PairVector operator*(Pair factor, const PairVector& a) { return {factor * a.x, factor * a.y, factor * a.z}; }

Pair squareRoot(Pair v) { return Pair{std::sqrt(v[0]), std::sqrt(v[1])}; }

// Numbers between four pixels (row by row), and how they change from row to row and from column to column there.
struct Interpolation {
  PairVector value, per_row, per_col;
};

// Writes coordinates of the first `count` of two corners.
void store(Pair x, Pair y, Eigen::Vector2d OutlinePoint::*member, OutlinePoint* out, int count) {
  for (int k = 0; k < count; ++k) out[k].*member = {x[k], y[k]};
}

}  // namespace

// Two corners between four pixels each, and the ranges that they may have.
struct CornerProjection::PlacePair {
  int pixels[kPair][4];
  Pair row, col;  // -0.5 and 1.5 at the border: the same expression extrapolates
  Pair shortest, longest;
};

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

void CornerProjection::place(const PixelCorner& corner, int k, PlacePair& out) {
  // The corner lies half a pixel before its pixel's centre, or a little off if it is pulled.
  const int r0 = std::clamp(corner.row - 1, 0, std::max(0, grid_.rows - 2));
  const int c0 = std::clamp(corner.col - 1, 0, std::max(0, grid_.cols - 2));
  const int r1 = std::min(r0 + 1, grid_.rows - 1);
  const int c1 = std::min(c0 + 1, grid_.cols - 1);
  int(&pixels)[4] = out.pixels[k];
  pixels[0] = grid_.index(r0, c0);
  pixels[1] = grid_.index(r0, c1);
  pixels[2] = grid_.index(r1, c0);
  pixels[3] = grid_.index(r1, c1);
  measureAround(pixels);
  out.row[k] = corner.row - 0.5 + kPull * corner.pull_row - r0;
  out.col[k] = corner.col - 0.5 + kPull * corner.pull_col - c0;
  out.shortest[k] = shortest_;
  out.longest[k] = longest_;
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

void CornerProjection::project(const PixelCorner* corners, std::size_t count, OutlinePoint* out) {
  PlacePair places;
  for (std::size_t i = 0; i < count; i += kPair) {
    const int corners_left = static_cast<int>(std::min<std::size_t>(kPair, count - i));
    place(corners[i], 0, places);
    place(corners[i + (corners_left > 1 ? 1 : 0)], 1, places);
    projectPair(places, corners_left, out + i);
  }
}

void CornerProjection::projectPair(const PlacePair& at, int count, OutlinePoint* out) {
  const auto interpolate = [&at](const float* values, Pair& value, Pair& per_row, Pair& per_col) {
    const auto read = [&](int k) { return Pair{values[at.pixels[0][k]], values[at.pixels[1][k]]}; };
    const Pair v00 = read(0), v01 = read(1), v10 = read(2), v11 = read(3);
    const Pair upper_step = v01 - v00, lower_step = v11 - v10;
    const Pair upper = v00 + at.col * upper_step;
    const Pair lower = v10 + at.col * lower_step;
    per_row = lower - upper;
    per_col = upper_step + at.row * (lower_step - upper_step);
    value = upper + at.row * per_row;
  };
  const auto interpolateAll = [&](const float* const(&values)[3]) {
    Interpolation all;
    interpolate(values[0], all.value.x, all.per_row.x, all.per_col.x);
    interpolate(values[1], all.value.y, all.per_row.y, all.per_col.y);
    interpolate(values[2], all.value.z, all.per_row.z, all.per_col.z);
    return all;
  };
  const Interpolation direction = interpolateAll(directions_);
  const Interpolation origin = grid_.origin_x.empty() ? Interpolation{} : interpolateAll(origins_);

  const PairVector& u = direction.value;
  const Pair norm = squareRoot(u.x * u.x + u.y * u.y + u.z * u.z), tiny = Pair{} + 1e-6;
  const Pair length = tiny < norm ? norm : tiny;
  const Pair least = at.shortest / kRangeFactor / length, most = at.longest * kRangeFactor / length;
  const Eigen::Vector3d& n = region_.plane.normal;
  const Pair incidence = u.dot(n);
  const Pair t = (region_.plane.d - origin.value.dot(n)) / incidence;
  const auto within = (least <= t) & (t <= most);
  const Pair limit = ((t > Pair{}) & (t < least)) ? least : most;  // a beam that misses the plane meets it at infinity
  const Pair range = within ? t : limit;

  const PairVector point = origin.value + range * u;
  const PairVector p{point.x - centre_.x(), point.y - centre_.y(), point.z - centre_.z()};
  store(p.dot(axis_x_), p.dot(axis_y_), &OutlinePoint::point, out, count);

  // Where the range is not limited it changes with the step, so that the point stays on the plane.
  const Pair along_x = u.dot(axis_x_) / incidence, along_y = u.dot(axis_y_) / incidence;
  const auto step = [&](const PairVector& change, Eigen::Vector2d OutlinePoint::*member) {
    const Pair x = change.dot(axis_x_), y = change.dot(axis_y_), away = change.dot(n);
    store(within ? x - away * along_x : x, within ? y - away * along_y : y, member, out, count);
  };
  step(origin.per_row + range * direction.per_row, &OutlinePoint::row_step);
  step(origin.per_col + range * direction.per_col, &OutlinePoint::col_step);
  for (int k = 0; k < count; ++k) limited_ += within[k] == 0 ? 1 : 0;
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
