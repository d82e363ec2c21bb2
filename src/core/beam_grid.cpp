// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_grid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoRange = 1e-6F;      // so close to the viewpoint, a point has no direction [m]
constexpr float kFarthest = 1e6F;      // beyond, planes of what is near have no digits left [m]
constexpr float kNoDirection = 0.01F;  // between opposite directions there is none: their mean is shorter than this

void resize(BeamGrid& grid, int rows, int cols, bool with_origins) {
  grid.rows = rows;
  grid.cols = cols;
  const auto n = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  for (auto* v : {&grid.dir_x, &grid.dir_y, &grid.dir_z}) v->assign(n, 0.0F);
  grid.range.assign(n, kNaN);
  for (auto* v : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) v->assign(with_origins ? n : 0, 0.0F);
}

// Fills the directions of invalid pixels of one row: linear between the valid neighbours, continued beyond the outermost
// ones with the step between the two nearest valid beams. A row without any valid pixel stays as it is.
void fillRow(BeamGrid& grid, int row) {
  int previous = -1;
  const auto set = [&](int col, const Eigen::Vector3f& d, const Eigen::Vector3f& otherwise) {
    const int i = grid.index(row, col);
    const Eigen::Vector3f u = d.norm() > kNoDirection ? d.normalized() : otherwise;
    grid.dir_x[i] = u.x();
    grid.dir_y[i] = u.y();
    grid.dir_z[i] = u.z();
  };
  int first = -1, second = -1, last = -1, before_last = -1;
  for (int c = 0; c < grid.cols; ++c) {
    if (!grid.valid(grid.index(row, c))) continue;
    if (previous >= 0) {
      const Eigen::Vector3f a = grid.direction(grid.index(row, previous));
      const Eigen::Vector3f b = grid.direction(grid.index(row, c));
      for (int j = previous + 1; j < c; ++j) {
        const float t = static_cast<float>(j - previous) / static_cast<float>(c - previous);
        set(j, a + t * (b - a), a);
      }
    }
    if (first < 0) {
      first = c;
    } else if (second < 0) {
      second = c;
    }
    before_last = last;
    last = c;
    previous = c;
  }
  if (first < 0) return;
  const auto extend = [&](int from, int towards, int col) {
    const Eigen::Vector3f a = grid.direction(grid.index(row, from));
    if (towards < 0) return set(col, a, a);
    const Eigen::Vector3f b = grid.direction(grid.index(row, towards));
    const float t = static_cast<float>(col - from) / static_cast<float>(from - towards);
    // Never further than the beam next door turned by a quarter: a wide gap must not fold the row over itself.
    set(col, a + std::clamp(t, 0.0F, 1.0F / std::max(1e-6F, (a - b).norm())) * (a - b), a);
  };
  for (int c = first - 1; c >= 0; --c) extend(first, second, c);
  for (int c = last + 1; c < grid.cols; ++c) extend(last, before_last, c);
}

// Whether the row has been filled.
bool hasDirections(const BeamGrid& grid, int row) { return !grid.direction(grid.index(row, 0)).isZero(0.0F); }

}  // namespace

BeamGrid beamGridFromPoints(int rows, int cols, const std::vector<float>& x, const std::vector<float>& y,
                            const std::vector<float>& z, const Eigen::Vector3f& viewpoint) {
  BeamGrid grid;
  beamGridFromPoints(rows, cols, x, y, z, viewpoint, grid);
  return grid;
}

void beamGridFromPoints(int rows, int cols, const std::vector<float>& x, const std::vector<float>& y,
                        const std::vector<float>& z, const Eigen::Vector3f& viewpoint, BeamGrid& grid) {
  if (rows <= 0 || cols <= 0) {
    throw std::invalid_argument("cloud is empty (" + std::to_string(rows) + " rows, " + std::to_string(cols) + " columns)");
  }
  const auto n = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  if (x.size() != n || y.size() != n || z.size() != n) {
    throw std::invalid_argument("cloud has " + std::to_string(x.size()) +
                                " points, expected rows x cols = " + std::to_string(n));
  }
  grid.beams_exact = false;
  const bool shifted = !viewpoint.isZero();
  resize(grid, rows, cols, shifted);
  if (shifted) {
    std::fill(grid.origin_x.begin(), grid.origin_x.end(), viewpoint.x());
    std::fill(grid.origin_y.begin(), grid.origin_y.end(), viewpoint.y());
    std::fill(grid.origin_z.begin(), grid.origin_z.end(), viewpoint.z());
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = Eigen::Vector3f(x[i], y[i], z[i]) - viewpoint;
    const float range = p.norm();
    if (!(range > kNoRange && range < kFarthest)) continue;
    grid.range[i] = range;
    grid.dir_x[i] = p.x() / range;
    grid.dir_y[i] = p.y() / range;
    grid.dir_z[i] = p.z() / range;
  }
  for (int r = 0; r < rows; ++r) fillRow(grid, r);
  // A row without any measurement takes its directions from the nearest row that has some.
  int above = -1, below = 0;
  for (int r = 0; r < rows; ++r) {
    for (below = std::max(below, r); below < rows && !hasDirections(grid, below);) ++below;
    if (below == r) {
      above = r;
      continue;
    }
    const int source = above >= 0 && (below == rows || r - above <= below - r) ? above : below == rows ? -1 : below;
    for (int c = 0; c < cols; ++c) {
      const int i = grid.index(r, c);
      const Eigen::Vector3f d = source < 0 ? Eigen::Vector3f::UnitX() : grid.direction(grid.index(source, c));
      grid.dir_x[i] = d.x();
      grid.dir_y[i] = d.y();
      grid.dir_z[i] = d.z();
    }
  }
}

}  // namespace ppc
