// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/moments.h"

namespace ppc {

/// @brief Moments of pixels with unit noise, w = r^2, and the sum of their ranges.
struct BlockMoments {
  Moments moments;      ///< about the centre
  double ranges = 0.0;  ///< [m]

  double meanRange() const { return moments.n > 0 ? ranges / moments.n : 0.0; }
};

/// @brief Sums the chosen valid pixels of rows [row_begin, row_end) and columns [col_begin, col_end), four at a time.
///
/// In single precision about one of the block's own points, then moved to `center` in double precision: the residuals of a
/// plane fit survive the difference of large numbers that they are, as long as the block is small beside its range.
/// @param choose LaneMask(int i, int count): which of the `count` pixels from i on are wanted.
template <typename Choose>
BlockMoments sumBlock(const BeamGrid& grid, const Eigen::Vector3d& center, int row_begin, int row_end, int col_begin,
                      int col_end, Choose&& choose) {
  Lanes w = {}, x = {}, y = {}, z = {}, xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {}, ranges = {};
  LaneMask counted = {};
  Eigen::Vector3f first = Eigen::Vector3f::Zero();
  bool started = false;
  for (int r = row_begin; r < row_end; ++r) {
    for (int c = col_begin; c < col_end; c += kLanes) {
      const int i = grid.index(r, c), count = col_end - c;
      const LaneMask chosen = choose(i, count);
      if (!anyLane(chosen & firstLanes(count))) continue;
      const BeamLanes beam(grid, i, count);
      const LaneMask used = beam.valid & chosen;
      if (!anyLane(used)) continue;
      if (!started) {
        for (int lane = 0; !started; ++lane) {
          started = used[lane] != 0;
          if (started) first = grid.point(i + lane);
        }
      }
      const Lanes range = used ? beam.range : Lanes{};
      const Lanes weight = range * range;
      const Lanes px = used ? beam.origin_x + range * beam.dir_x - first.x() : Lanes{};
      const Lanes py = used ? beam.origin_y + range * beam.dir_y - first.y() : Lanes{};
      const Lanes pz = used ? beam.origin_z + range * beam.dir_z - first.z() : Lanes{};
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
  }
  BlockMoments out;
  if (!started) return out;
  // p = q + d with q about the block's point: sum w p p^T = sum w q q^T + d sum w q^T + sum w q d^T + d d^T sum w
  const double dx = first.x() - center.x(), dy = first.y() - center.y(), dz = first.z() - center.z();
  const double sw = sumLanes(w), sx = sumLanes(x), sy = sumLanes(y), sz = sumLanes(z);
  Moments& m = out.moments;
  m.w = sw;
  m.x = sx + sw * dx;
  m.y = sy + sw * dy;
  m.z = sz + sw * dz;
  m.xx = sumLanes(xx) + (sx + m.x) * dx;
  m.xy = sumLanes(xy) + sx * dy + m.y * dx;
  m.xz = sumLanes(xz) + sx * dz + m.z * dx;
  m.yy = sumLanes(yy) + (sy + m.y) * dy;
  m.yz = sumLanes(yz) + sy * dz + m.z * dy;
  m.zz = sumLanes(zz) + (sz + m.z) * dz;
  m.n = countLanes(counted);
  out.ranges = sumLanes(ranges);
  return out;
}

}  // namespace ppc
