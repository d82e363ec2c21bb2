// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <cstdint>

namespace ppc {

/// Sums of points about one of them, so that they keep their digits far from the sensor.
struct PointSums {
  double ux = 0, uy = 0, uz = 0;  ///< beams, one for each block
  double x = 0, y = 0, z = 0;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  int n = 0;

  PointSums& operator+=(const PointSums& o);
};

/// Adds the valid pixels [begin, end), some hundred at most, about `origin`.
void addPoints(const BeamGrid& grid, int begin, int end, const Eigen::Vector3d& origin, PointSums& s);

/// @brief Total least squares: for regions seen edge-on, whose beams do not tell the plane. `rms` is the root of the
/// smallest eigenvalue; the covariance is for errors of unit variance across the plane.
PlanarRegion fitAcross(std::int32_t id, const Eigen::Vector3d& origin, const PointSums& s);

}  // namespace ppc
