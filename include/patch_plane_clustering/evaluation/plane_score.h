// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/evaluation/segcomp.h"

#include <vector>

namespace ppc {

/// @brief Errors of the planes of correctly detected regions.
struct PlaneScore {
  int matched = 0;
  double mean_normal_error = 0.0;   ///< angle between the normals [rad]
  double mean_offset_error = 0.0;   ///< distance of the true region's centroid from the found plane [m]
  double worst_normal_error = 0.0;  ///< [rad]
  double worst_offset_error = 0.0;  ///< [m]
};

/// @brief Compares the planes of matched regions. @param truth,found planes by id, ascending; regions without one are left
/// out.
PlaneScore planeScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& found,
                      const RegionOverlap& overlap, const SegcompScore& matches);

/// @brief The same for fits to the true pixels: the error that the data leave to any method. @param refits planes fitted to
/// the pixels of the true regions, by id, ascending.
PlaneScore refitScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& refits,
                      const RegionOverlap& overlap, const SegcompScore& matches);

}  // namespace ppc
