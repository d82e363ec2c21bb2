// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/corner_projection.h"

#include "patch_plane_clustering/core/lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

namespace ppc {
namespace {

// How far the range of a corner may leave the ranges measured around it. Half a step of a usual scan changes the range by
// more only below 2 degrees of grazing, where the plane's own error decides where the beam meets it.
constexpr double kRangeFactor = 1.25;

// How far the corner of a diagonal touch moves into its own pixel, in pixels.
constexpr float kPull = 0.25F;

// Two numbers of single precision: half of four lanes.
using Half = float __attribute__((vector_size(8)));

// Coordinates of four corners each, or of two in double precision.
struct LanesVector {
  Lanes x, y, z;

  Lanes dot(const Eigen::Vector3f& v) const { return v.x() * x + v.y() * y + v.z() * z; }
};
struct PairVector {
  Pair x, y, z;

  Pair dot(const Eigen::Vector3d& v) const { return v.x() * x + v.y() * y + v.z() * z; }
};

LanesVector operator+(const LanesVector& a, const LanesVector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
LanesVector operator*(Lanes factor, const LanesVector& a) { return {factor * a.x, factor * a.y, factor * a.z}; }

Pair widen(Lanes v, int half) {
  const Half two = half == 0 ? __builtin_shufflevector(v, v, 0, 1) : __builtin_shufflevector(v, v, 2, 3);
  return __builtin_convertvector(two, Pair);
}
Lanes narrow(Pair low, Pair high) {
  const Half a = __builtin_convertvector(low, Half), b = __builtin_convertvector(high, Half);
  return __builtin_shufflevector(a, b, 0, 1, 2, 3);
}

// Upper left pixels of the squares of four pixels around four corners, and where the corners lie in them.
struct Places {
  int upper[kLanes], lower[kLanes];  // pixels
  Lanes row, col;                    // 0.5 in the middle; -0.5 and 1.5 at the border: the same expression extrapolates
};

// Numbers of two neighbouring pixels of a row.
template <bool kOneColumn, typename Number>
double readTwo(const std::vector<Number>& values, int pixel) {
  const Number* const from = values.data() + pixel;
  Number two[2] = {from[0], from[kOneColumn ? 0 : 1]};
  double both;
  static_assert(sizeof both == sizeof two, "numbers are four bytes wide");
  std::memcpy(&both, two, sizeof both);
  return both;
}

// Numbers of the pixels on the left and on the right.
template <typename Vector>
struct Sides {
  Vector left, right;
};
template <bool kOneColumn, typename Vector, typename Number>
Sides<Vector> readSides(const std::vector<Number>& values, const int (&pixels)[kLanes]) {
  const auto read = [&](int k) { return readTwo<kOneColumn>(values, pixels[k]); };
  const Vector a = reinterpret_cast<Vector>(Pair{read(0), read(1)}), b = reinterpret_cast<Vector>(Pair{read(2), read(3)});
  return {__builtin_shufflevector(a, b, 0, 2, 4, 6), __builtin_shufflevector(a, b, 1, 3, 5, 7)};
}

// A number between four pixels: that of the first, and the rest; and how it changes from row to row and from column to
// column there. Beams of neighbouring pixels differ by little: single precision does for the differences.
struct Interpolation {
  Lanes first, rest, per_row, per_col;
};
template <bool kOneColumn>
inline __attribute__((always_inline)) void interpolate(const std::vector<float>& values, const Places& at,
                                                       Interpolation& out) {
  const auto upper = readSides<kOneColumn, Lanes>(values, at.upper), lower = readSides<kOneColumn, Lanes>(values, at.lower);
  const Lanes step = upper.right - upper.left, twist = (lower.right - lower.left) - step;
  out.first = upper.left;
  out.per_row = (lower.left - upper.left) + at.col * twist;
  out.per_col = step + at.row * twist;
  out.rest = at.col * step + at.row * out.per_row;
}

// The same of the three coordinates of a vector.
struct VectorInterpolation {
  Interpolation x, y, z;

  PairVector value(int half) const {
    const auto add = [half](const Interpolation& v) { return widen(v.first, half) + widen(v.rest, half); };
    return {add(x), add(y), add(z)};
  }
  LanesVector perRow() const { return {x.per_row, y.per_row, z.per_row}; }
  LanesVector perCol() const { return {x.per_col, y.per_col, z.per_col}; }
};
Places placesOf(const PixelCorner* corners, int count, const BeamGrid& grid) {
  Places out;
  LaneMask row, col, pull_row, pull_col;
  const int last_row = std::max(0, grid.rows - 2), last_col = std::max(0, grid.cols - 2);
  const int below = grid.rows > 1 ? grid.cols : 0;
  for (int k = 0; k < kLanes; ++k) {
    const PixelCorner& corner = corners[std::min(k, count - 1)];
    const int r = std::clamp(corner.row - 1, 0, last_row), c = std::clamp(corner.col - 1, 0, last_col);
    out.upper[k] = grid.index(r, c);
    out.lower[k] = out.upper[k] + below;
    row[k] = corner.row - r;
    col[k] = corner.col - c;
    pull_row[k] = corner.pull_row;
    pull_col[k] = corner.pull_col;
  }
  // The corner lies half a pixel before its pixel's centre, or a little off if it is pulled.
  const auto numbers = [](LaneMask v) { return __builtin_convertvector(v, Lanes); };
  out.row = numbers(row) - 0.5F + kPull * numbers(pull_row);
  out.col = numbers(col) - 0.5F + kPull * numbers(pull_col);
  return out;
}

// Shortest and longest range of the region's own pixels around four corners; infinity and 0 where there is none.
struct RangesAround {
  Lanes shortest, longest;
};
template <bool kOneColumn>
RangesAround rangesAround(const BeamGrid& grid, const LabelImage& labels, std::int32_t id, const Places& at) {
  const Lanes none{};
  RangesAround around{fill(std::numeric_limits<float>::infinity()), none};
  const auto add = [&](Lanes range, LaneMask label) {
    const LaneMask own = (label == fillMask(id)) & (range > none);
    around.shortest = (own & (range < around.shortest)) ? range : around.shortest;
    around.longest = (own & (range > around.longest)) ? range : around.longest;
  };
  const auto addRow = [&](const int(&pixels)[kLanes]) {
    const auto range = readSides<kOneColumn, Lanes>(grid.range, pixels);
    const auto label = readSides<kOneColumn, LaneMask>(labels.labels, pixels);
    add(range.left, label.left);
    add(range.right, label.right);
  };
  addRow(at.upper);
  addRow(at.lower);
  return around;
}

}  // namespace

CornerProjection::CornerProjection(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region)
    : grid_(grid), labels_(labels), region_(region) {
  const Eigen::Vector3d& n = region.plane.normal;
  centre_ = region.centroid - region.plane.signedDistance(region.centroid) * n;
  axis_x_ = n.unitOrthogonal();
  axis_y_ = n.cross(axis_x_);
  centre_x_ = centre_.dot(axis_x_);
  centre_y_ = centre_.dot(axis_y_);
  single_ = {axis_x_.cast<float>(), axis_y_.cast<float>(), n.cast<float>()};
  shortest_ = longest_ = std::max(1e-3F, static_cast<float>(region.centroid.norm()));
}

void CornerProjection::project(const PixelCorner* corners, std::size_t count, OutlinePoint* out) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const int corners_left = static_cast<int>(std::min<std::size_t>(kLanes, count - i));
    if (grid_.cols > 1) {
      projectFour<false>(corners + i, corners_left, out + i);
    } else {
      projectFour<true>(corners + i, corners_left, out + i);
    }
  }
}

template <bool kOneColumn>
void CornerProjection::projectFour(const PixelCorner* corners, int count, OutlinePoint* out) {
  const Places at = placesOf(corners, count, grid_);
  RangesAround around = rangesAround<kOneColumn>(grid_, labels_, region_.id, at);
  if (anyLane(around.longest == Lanes{})) {  // the limits of the corner before apply
    for (int k = 0; k < kLanes; ++k) {
      if (around.longest[k] == 0.0F) {
        around.shortest[k] = k == 0 ? shortest_ : around.shortest[k - 1];
        around.longest[k] = k == 0 ? longest_ : around.longest[k - 1];
      }
    }
  }
  shortest_ = around.shortest[kLanes - 1];
  longest_ = around.longest[kLanes - 1];

  VectorInterpolation direction, origin;
  interpolate<kOneColumn>(grid_.dir_x, at, direction.x);
  interpolate<kOneColumn>(grid_.dir_y, at, direction.y);
  interpolate<kOneColumn>(grid_.dir_z, at, direction.z);
  const bool moving = !grid_.origin_x.empty();
  if (moving) {
    interpolate<kOneColumn>(grid_.origin_x, at, origin.x);
    interpolate<kOneColumn>(grid_.origin_y, at, origin.y);
    interpolate<kOneColumn>(grid_.origin_z, at, origin.z);
  }

  // Where the beams meet the plane, in double precision.
  const Eigen::Vector3d& n = region_.plane.normal;
  Pair t[2], from_x[2], from_y[2], ahead_x[2], ahead_y[2], along_x[2], along_y[2], square[2];
  for (int half = 0; half < 2; ++half) {
    const PairVector u = direction.value(half);
    square[half] = u.x * u.x + u.y * u.y + u.z * u.z;
    const Pair zero{}, inverse = 1.0 / u.dot(n);
    Pair away = zero + region_.plane.d;
    from_x[half] = zero - centre_x_;
    from_y[half] = zero - centre_y_;
    if (moving) {
      const PairVector o = origin.value(half);
      away -= o.dot(n);
      from_x[half] += o.dot(axis_x_);
      from_y[half] += o.dot(axis_y_);
    }
    t[half] = away * inverse;
    ahead_x[half] = u.dot(axis_x_);
    ahead_y[half] = u.dot(axis_y_);
    along_x[half] = ahead_x[half] * inverse;
    along_y[half] = ahead_y[half] * inverse;
  }

  // Limits apply to lengths, not to multiples of directions, which are a little shorter than 1 between two beams.
  const Lanes reached = narrow(t[0], t[1]), length2 = reached * reached * narrow(square[0], square[1]);
  constexpr float kLeast2 = static_cast<float>(1.0 / (kRangeFactor * kRangeFactor));
  constexpr float kMost2 = static_cast<float>(kRangeFactor * kRangeFactor);
  const LaneMask within = (reached > Lanes{}) & (length2 >= kLeast2 * around.shortest * around.shortest) &
                          (length2 <= kMost2 * around.longest * around.longest);
  const LaneMask outside = ~within & firstLanes(count);
  if (anyLane(outside)) {
    for (int k = 0; k < count; ++k) {
      if (within[k] != 0) continue;
      const int half = k / kPair, i = k % kPair;
      const double length = std::max(1e-6, std::sqrt(square[half][i]));
      const double least = around.shortest[k] / kRangeFactor / length, most = around.longest[k] * kRangeFactor / length;
      // A beam that misses the plane meets it at infinity.
      t[half][i] = t[half][i] > 0.0 && t[half][i] < least ? least : most;
    }
    limited_ += static_cast<std::size_t>(countLanes(outside));
  }

  // Where the range is not limited it changes with the step, so that the point stays on the plane.
  const Lanes range = narrow(t[0], t[1]), by_x = narrow(along_x[0], along_x[1]), by_y = narrow(along_y[0], along_y[1]);
  struct Step {
    Lanes x, y;
  };
  const auto step = [&](const LanesVector& change) {
    const Lanes x = change.dot(single_.axis_x), y = change.dot(single_.axis_y), away = change.dot(single_.normal);
    return Step{within ? x - away * by_x : x, within ? y - away * by_y : y};
  };
  LanesVector row_change = range * direction.perRow(), col_change = range * direction.perCol();
  if (moving) {
    row_change = origin.perRow() + row_change;
    col_change = origin.perCol() + col_change;
  }
  const Step row = step(row_change), col = step(col_change);
  const Pair x[2] = {from_x[0] + t[0] * ahead_x[0], from_x[1] + t[1] * ahead_x[1]};
  const Pair y[2] = {from_y[0] + t[0] * ahead_y[0], from_y[1] + t[1] * ahead_y[1]};
  for (int k = 0; k < count; ++k) {
    out[k].point = {x[k / kPair][k % kPair], y[k / kPair][k % kPair]};
    out[k].row_step = {row.x[k], row.y[k]};
    out[k].col_step = {col.x[k], col.y[k]};
  }
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
