// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/moments.h"

namespace ppc {

/// @file Moments of blocks of pixels, four pixels at a time. In single precision about one of the block's own points, then
/// moved to the centre in double precision: the residuals of a plane fit survive the difference of large numbers that they
/// are, as long as the block is small beside its range.

/// @brief Sums of a block's pixels with unit noise, w = r^2, lane by lane.
struct BlockSums {
  Eigen::Vector3f first = Eigen::Vector3f::Zero();  ///< the block's first point: all coordinates are less this
  Lanes w = {}, x = {}, y = {}, z = {}, xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {};
  Lanes ranges = {};
  LaneMask counted = {};
  bool empty = true;

  /// Adds the chosen valid ones of the beams from pixel i on.
  void add(const BeamGrid& grid, int i, const BeamLanes& beam, LaneMask chosen) {
    const LaneMask used = beam.valid & chosen;
    if (empty) {
      if (!anyLane(used)) return;
      for (int lane = 0; empty; ++lane) {
        empty = used[lane] == 0;
        if (!empty) first = grid.point(i + lane);
      }
    }
    // Elsewhere the range is 0, and so are the weight and all sums.
    const Lanes range = used ? beam.range : Lanes{};
    const Lanes weight = range * range;
    const Lanes px = beam.origin_x + range * beam.dir_x - first.x();
    const Lanes py = beam.origin_y + range * beam.dir_y - first.y();
    const Lanes pz = beam.origin_z + range * beam.dir_z - first.z();
    const Lanes wx = weight * px, wy = weight * py, wz = weight * pz;
    w += weight;
    x += wx;
    y += wy;
    z += wz;
    xx += wx * px;
    xy += wx * py;
    xz += wx * pz;
    yy += wy * py;
    yz += wy * pz;
    zz += wz * pz;
    ranges += range;
    counted += used;
  }
};

/// @brief Sums the chosen valid pixels of rows [row_begin, row_end) and columns [col_begin, col_end).
/// @param choose LaneMask(int i, int count): which of the `count` pixels from i on are wanted.
template <typename Choose>
BlockSums sumPixels(const BeamGrid& grid, int row_begin, int row_end, int col_begin, int col_end, Choose&& choose) {
  BlockSums s;
  const int rows = row_end - row_begin;
  for (int c = col_begin; c < col_end; c += kLanes) {  // downwards: patches are rarely wider than this
    const int first = grid.index(row_begin, c), count = std::min(kLanes, col_end - c);
    if (count == kLanes) {
      for (int row = 0, i = first; row < rows; ++row, i += grid.cols) {
        const LaneMask chosen = choose(i, kLanes);
        if (anyLane(chosen)) s.add(grid, i, BeamLanes(grid, i), chosen);
      }
    } else {
      for (int row = 0, i = first; row < rows; ++row, i += grid.cols) {
        const LaneMask chosen = choose(i, count) & firstLanes(count);
        if (anyLane(chosen)) s.add(grid, i, BeamLanes(grid, i, count), chosen);
      }
    }
  }
  return s;
}

/// @brief Moments of a block, or of two, about the centre. @tparam T double or Pair.
template <typename T>
struct BlockMoments {
  T xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {}, x = {}, y = {}, z = {}, w = {};
  T ranges = {};  ///< sum [m]

  /// @param total T(Lanes BlockSums::*): the sum over the lanes. @param dx,dy,dz from the centre to the blocks' first
  /// points.
  template <typename Total>
  BlockMoments(const Total& total, T dx, T dy, T dz) {
    // p = q + d with q about the block's point: sum w p p^T = sum w q q^T + d sum w q^T + sum w q d^T + d d^T sum w
    const T sx = total(&BlockSums::x), sy = total(&BlockSums::y), sz = total(&BlockSums::z);
    w = total(&BlockSums::w);
    x = sx + w * dx;
    y = sy + w * dy;
    z = sz + w * dz;
    xx = total(&BlockSums::xx) + (sx + x) * dx;
    xy = total(&BlockSums::xy) + sx * dy + y * dx;
    xz = total(&BlockSums::xz) + sx * dz + z * dx;
    yy = total(&BlockSums::yy) + (sy + y) * dy;
    yz = total(&BlockSums::yz) + sy * dz + z * dy;
    zz = total(&BlockSums::zz) + (sz + z) * dz;
    ranges = total(&BlockSums::ranges);
  }
};

inline double numberOf(double value, int /*k*/) { return value; }
inline double numberOf(Pair pair, int k) { return pair[k]; }

/// Moments of the k-th block, of `n` points.
template <typename T>
Moments momentsOf(const BlockMoments<T>& m, int k, int n) {
  const auto at = [k](T value) { return numberOf(value, k); };
  return {at(m.xx), at(m.xy), at(m.xz), at(m.yy), at(m.yz), at(m.zz), at(m.x), at(m.y), at(m.z), at(m.w), n};
}

inline BlockMoments<double> momentsOf(const BlockSums& sums, const Eigen::Vector3d& center) {
  return {[&](Lanes BlockSums::*sum) -> double { return sumLanes(sums.*sum); }, sums.first.x() - center.x(),
          sums.first.y() - center.y(), sums.first.z() - center.z()};
}

/// The same for two blocks at a time.
inline BlockMoments<Pair> momentsOf(const BlockSums& a, const BlockSums& b, const Eigen::Vector3d& center) {
  return {[&](Lanes BlockSums::*sum) { return sumLanes(a.*sum, b.*sum); }, Pair{a.first.x(), b.first.x()} - center.x(),
          Pair{a.first.y(), b.first.y()} - center.y(), Pair{a.first.z(), b.first.z()} - center.z()};
}

}  // namespace ppc
