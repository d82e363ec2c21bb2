// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/similarity.h"

#include <Eigen/Core>

namespace ppc {

/// @brief An image whose regions are judged: its beams, how their ranges may err, and what a region has at least. What it
/// refers to must outlive it.
struct JudgedImage {
  const BeamGrid& grid;
  Eigen::Vector3d center;  ///< origin of the regions' planes (see moments.h), about which beams begin [m]
  const NoiseModel& noise;
  const CoplanarityTolerance& tolerance;
  int smallest;  ///< points that a region has at least
};

}  // namespace ppc
