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

  /// Adds points with their ranges, in the lanes used; elsewhere the range is 0.
  void add(LaneMask used, Lanes range, Lanes px, Lanes py, Lanes pz) {
    const Lanes weight = range * range;
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

/// @brief A block of pixels: rows [row_begin, row_end) and columns [col_begin, col_end) of a grid.
struct PixelBlock {
  int row_begin, row_end, col_begin, col_end;
};

/// The first of the chosen valid pixels of a block, downwards in four columns at a time; -1 if there is none.
template <typename Choose>
int firstPixel(const BeamGrid& grid, const PixelBlock& block, const Choose& choose) {
  for (int c = block.col_begin; c < block.col_end; c += kLanes) {
    const int count = std::min(kLanes, block.col_end - c);
    for (int row = block.row_begin; row < block.row_end; ++row) {
      const int i = grid.index(row, c);
      const LaneMask chosen = choose(i, count);
      if (!anyLane(chosen)) continue;
      for (int lane = 0; lane < count; ++lane) {
        if (chosen[lane] != 0 && grid.valid(i + lane)) return i + lane;
      }
    }
  }
  return -1;
}

/// Sums the chosen valid pixels of a block about one of them. @tparam kOrigins whether the beams have any.
template <bool kOrigins, typename Choose>
void sumAbout(const Eigen::Vector3f& first, const BeamGrid& grid, const PixelBlock& block, const Choose& choose,
              BlockSums& sums) {
  const Lanes first_x = fill(first.x()), first_y = fill(first.y()), first_z = fill(first.z());
  BlockSums s;  // known to nobody else, and so in registers
  const auto add = [&](const BeamLanes& beam, LaneMask chosen) {
    const LaneMask used = beam.valid & chosen;
    const Lanes range = used ? beam.range : Lanes{};
    if constexpr (kOrigins) {
      s.add(used, range, beam.origin_x + range * beam.dir_x - first_x, beam.origin_y + range * beam.dir_y - first_y,
            beam.origin_z + range * beam.dir_z - first_z);
    } else {
      s.add(used, range, range * beam.dir_x - first_x, range * beam.dir_y - first_y, range * beam.dir_z - first_z);
    }
  };
  const int rows = block.row_end - block.row_begin;
  int c = block.col_begin;
  for (; c + kLanes <= block.col_end; c += kLanes) {  // downwards: patches are rarely wider than this
    for (int row = 0, i = grid.index(block.row_begin, c); row < rows; ++row, i += grid.cols) {
      const LaneMask chosen = choose(i, kLanes);
      if (anyLane(chosen)) add(BeamLanes(grid, i), chosen);
    }
  }
  if (const int count = block.col_end - c; count > 0) {
    for (int row = 0, i = grid.index(block.row_begin, c); row < rows; ++row, i += grid.cols) {
      const LaneMask chosen = choose(i, count) & firstLanes(count);
      if (anyLane(chosen)) add(BeamLanes(grid, i, count), chosen);
    }
  }
  sums = s;
  sums.first = first;
}

/// @brief Sums the chosen valid pixels of a block. @param choose LaneMask(int i, int count): which of the `count` pixels
/// from i on are wanted. @return false, and nothing is done, if there is none.
template <typename Choose>
bool sumPixels(const BeamGrid& grid, const PixelBlock& block, const Choose& choose, BlockSums& sums) {
  const int first = firstPixel(grid, block, choose);
  if (first < 0) return false;
  if (grid.origin_x.empty()) {
    sumAbout<false>(grid.point(first), grid, block, choose, sums);
  } else {
    sumAbout<true>(grid.point(first), grid, block, choose, sums);
  }
  return true;
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

/// Moments of one block, or of the first or second of two, of `n` points.
inline Moments momentsOf(const BlockMoments<double>& m, int n) {
  return {m.xx, m.xy, m.xz, m.yy, m.yz, m.zz, m.x, m.y, m.z, m.w, n};
}
inline Moments momentsOf(const BlockMoments<Pair>& m, int k, int n) {
  return {m.xx[k], m.xy[k], m.xz[k], m.yy[k], m.yz[k], m.zz[k], m.x[k], m.y[k], m.z[k], m.w[k], n};
}

inline BlockMoments<double> momentsOf(const BlockSums& sums, const Eigen::Vector3d& center) {
  return {[&](Lanes BlockSums::*sum) -> double { return sumLanes(sums.*sum); }, sums.first.x() - center.x(),
          sums.first.y() - center.y(), sums.first.z() - center.z()};
}

/// @brief Four blocks at a time: sums over the lanes of each, one lane a block.
struct BlockTotals {
  BlockSums sums;                   ///< its `first` means nothing
  Lanes first_x, first_y, first_z;  ///< of the blocks

  explicit BlockTotals(const BlockSums (&blocks)[kLanes]) {
    const auto sum = [&](auto BlockSums::*m) { sums.*m = sumLanes(blocks[0].*m, blocks[1].*m, blocks[2].*m, blocks[3].*m); };
    for (Lanes BlockSums::*m : {&BlockSums::w, &BlockSums::x, &BlockSums::y, &BlockSums::z, &BlockSums::xx, &BlockSums::xy,
                                &BlockSums::xz, &BlockSums::yy, &BlockSums::yz, &BlockSums::zz, &BlockSums::ranges}) {
      sum(m);
    }
    sum(&BlockSums::counted);
    const auto firsts = [&](int axis) {
      return Lanes{blocks[0].first[axis], blocks[1].first[axis], blocks[2].first[axis], blocks[3].first[axis]};
    };
    first_x = firsts(0);
    first_y = firsts(1);
    first_z = firsts(2);
  }

  int points(int block) const { return -sums.counted[block]; }
  BlockMoments<Pair> firstMoments(const Eigen::Vector3d& center) const { return moments(firstPair, center); }
  BlockMoments<Pair> lastMoments(const Eigen::Vector3d& center) const { return moments(lastPair, center); }

 private:
  template <typename PairOf>
  BlockMoments<Pair> moments(const PairOf& pair, const Eigen::Vector3d& center) const {
    return {[&](Lanes BlockSums::*sum) { return pair(sums.*sum); }, pair(first_x) - center.x(), pair(first_y) - center.y(),
            pair(first_z) - center.z()};
  }
};

}  // namespace ppc
