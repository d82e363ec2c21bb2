// SPDX-License-Identifier: BSD-3-Clause
// Beams of a range image: cosines and sines once a column, poses once a stretch between two knots, and what is left for each
// pixel in vector code, four at a time in single precision, as which it is stored: 30 m away the error is below 0.01 mm.
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

// Between opposite directions there is none: the square of their mean's length is smaller than this.
constexpr float kNoDirection2 = 1e-4F;

void fillIn(const RangeImage& image, BeamColumns& columns) {
  const auto size = static_cast<std::size_t>(image.cols) + kLanes - 1;
  columns.cosine.assign(size, 1.0F);
  columns.sine.assign(size, 0.0F);
  columns.along.assign(size, 0.0F);
  columns.begin.clear();
  const int stretches = std::max(1, image.poses_per_row - 1);
  for (int c = 0; c < image.cols; ++c) {
    const auto i = static_cast<std::size_t>(c);
    columns.cosine[i] = static_cast<float>(std::cos(image.bearing(c)));
    columns.sine[i] = static_cast<float>(std::sin(image.bearing(c)));
    const double at = image.poses_per_row == 1 || image.cols == 1
                          ? 0.0
                          : static_cast<double>(c) * (image.poses_per_row - 1) / (image.cols - 1);
    const int stretch = std::min(static_cast<int>(at), stretches - 1);
    columns.along[i] = static_cast<float>(at - stretch);
    columns.begin.resize(static_cast<std::size_t>(stretch) + 1, c);
  }
  columns.begin.resize(static_cast<std::size_t>(stretches) + 1, image.cols);
}

// A vector that changes linearly along a stretch.
struct Change {
  Lanes from[3], step[3];

  Change(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    for (int k = 0; k < 3; ++k) {
      from[k] = fill(static_cast<float>(a[k]));
      step[k] = fill(static_cast<float>(b[k] - a[k]));
    }
  }
  Lanes at(int axis, Lanes along) const { return from[axis] + along * step[axis]; }
};

Lanes squaredLength(const std::array<Lanes, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// 1 / sqrt of squared lengths. Axes interpolated between knots that are close have almost length 1: a series will do.
Lanes inverseRoot(Lanes squared) {
  const Lanes e = squared - 1.0F;
  constexpr float kClose = 3e-3F;  // error of the series: 1e-8
  if (!anyLane(e * e > fill(kClose * kClose))) return 1.0F + e * (-0.5F + e * 0.375F);
  Lanes inverse = {};
  for (int k = 0; k < kLanes; ++k) inverse[k] = 1.0F / std::sqrt(squared[k]);
  return inverse;
}

// Calls value(c) for every fourth column, which gives the vectors of this column and the next three, and writes them.
template <typename Value>
void fillColumns(int begin, int end, const std::array<float*, 3>& out, const Value& value) {
  int c = begin;
  for (; c + kLanes <= end; c += kLanes) {
    const std::array<Lanes, 3> v = value(static_cast<std::size_t>(c));
    for (std::size_t k = 0; k < 3; ++k) storeLanes(v[k], out[k] + c);
  }
  if (c == end) return;
  const std::array<Lanes, 3> v = value(static_cast<std::size_t>(c));
  for (std::size_t k = 0; k < 3; ++k) std::memcpy(out[k] + c, &v[k], sizeof(float) * static_cast<std::size_t>(end - c));
}

void fillDirections(const BeamColumns& columns, int begin, int end, const Change& x_axis, const Change& y_axis,
                    const std::array<float*, 3>& out) {
  const float *const cosines = columns.cosine.data(), *const sines = columns.sine.data();
  const float* const alongs = columns.along.data();  // not read again after what is written
  fillColumns(begin, end, out, [&](std::size_t c) {
    const Lanes cosine = loadLanes<Lanes>(cosines + c), sine = loadLanes<Lanes>(sines + c);
    const auto beam = [&](Lanes along) {
      return std::array<Lanes, 3>{x_axis.at(0, along) * cosine + y_axis.at(0, along) * sine,
                                  x_axis.at(1, along) * cosine + y_axis.at(1, along) * sine,
                                  x_axis.at(2, along) * cosine + y_axis.at(2, along) * sine};
    };
    Lanes along = loadLanes<Lanes>(alongs + c);
    std::array<Lanes, 3> u = beam(along);
    Lanes squared = squaredLength(u);
    const LaneMask opposite = ~(squared > fill(kNoDirection2));  // the knots: take the first one's
    if (anyLane(opposite)) {
      // cppcheck-suppress knownConditionTrueFalse  // it tells lane by lane
      along = opposite ? Lanes{} : along;
      u = beam(along);
      squared = squaredLength(u);
    }
    const Lanes factor = inverseRoot(squared);
    return std::array<Lanes, 3>{u[0] * factor, u[1] * factor, u[2] * factor};
  });
}

void fillOrigins(const BeamColumns& columns, int begin, int end, const Change& origin, const std::array<float*, 3>& out) {
  const float* const alongs = columns.along.data();
  fillColumns(begin, end, out, [&](std::size_t c) {
    const Lanes along = loadLanes<Lanes>(alongs + c);
    return std::array<Lanes, 3>{origin.at(0, along), origin.at(1, along), origin.at(2, along)};
  });
}

// Measurements [begin, end) within the limits, NaN in place of all others.
void fillRanges(const RangeImage& image, std::size_t begin, std::size_t end, std::vector<float>& out) {
  // The limits in single precision, rounded inwards, admit the same floats.
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  auto low = static_cast<float>(image.range_min), high = static_cast<float>(image.range_max);
  if (low < image.range_min) low = std::nextafter(low, kInfinity);
  if (high > image.range_max) high = std::nextafter(high, -kInfinity);
  const std::size_t whole = end - (end - begin) % kLanes;
  const Lanes lows = fill(low), highs = fill(high), bad = fill(std::numeric_limits<float>::quiet_NaN());
  const auto filtered = [&](Lanes r) { return ((r > Lanes{}) & (lows <= r) & (r <= highs)) ? r : bad; };
  for (std::size_t i = begin; i < whole; i += kLanes) {
    const Lanes kept = filtered(loadLanes<Lanes>(&image.ranges[i]));
    std::memcpy(&out[i], &kept, sizeof kept);
  }
  for (std::size_t i = whole; i < end; ++i) out[i] = filtered(fill(image.ranges[i]))[0];
}

// Rows [begin, end), of a grid that has its size.
void fillRows(const RangeImage& image, const BeamColumns& columns, int begin, int end, BeamGrid& grid) {
  fillRanges(image, static_cast<std::size_t>(grid.index(begin, 0)), static_cast<std::size_t>(grid.index(end, 0)),
             grid.range);
  const auto knots = static_cast<std::size_t>(image.poses_per_row);
  for (int r = begin; r < end; ++r) {
    const Eigen::Isometry3d* poses = &image.line_poses[static_cast<std::size_t>(r) * knots];
    const auto row = static_cast<std::size_t>(grid.index(r, 0));
    for (std::size_t k = 0; k + 1 < columns.begin.size(); ++k) {
      const int first = columns.begin[k], last = columns.begin[k + 1];
      const Eigen::Isometry3d &a = poses[k], &b = poses[std::min(k + 1, knots - 1)];
      fillDirections(columns, first, last, Change(a.linear().col(0), b.linear().col(0)),
                     Change(a.linear().col(1), b.linear().col(1)),
                     {grid.dir_x.data() + row, grid.dir_y.data() + row, grid.dir_z.data() + row});
      if (grid.origin_x.empty()) continue;
      fillOrigins(columns, first, last, Change(a.translation(), b.translation()),
                  {grid.origin_x.data() + row, grid.origin_y.data() + row, grid.origin_z.data() + row});
    }
  }
}

}  // namespace

void toBeamGrid(const RangeImage& image, BeamColumns& columns, BeamGrid& grid, int threads) {
  checkConsistent(image);
  const bool same_origin = std::all_of(image.line_poses.begin(), image.line_poses.end(),
                                       [](const Eigen::Isometry3d& pose) { return pose.translation().isZero(1e-9); });
  grid.rows = image.rows;
  grid.cols = image.cols;
  grid.beams_exact = true;
  const std::size_t n = image.ranges.size();
  for (auto* v : {&grid.dir_x, &grid.dir_y, &grid.dir_z, &grid.range}) v->resize(n);
  for (auto* v : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) v->resize(same_origin ? 0 : n);
  fillIn(image, columns);
  forEachRange(threads, image.rows, [&](int begin, int end) { fillRows(image, columns, begin, end, grid); });
}

BeamGrid toBeamGrid(const RangeImage& image) {
  BeamColumns columns;
  BeamGrid grid;
  toBeamGrid(image, columns, grid);
  return grid;
}

}  // namespace ppc
