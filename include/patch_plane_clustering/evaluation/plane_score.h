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
  /// Normalised errors squared: their median (median()), and the share of them within the ellipsoid that holds 95 % of a
  /// plane's covariance. Chi-square with three degrees of freedom has 2.37; infinite where a covariance is none.
  double median_normalised_error = 0.0;
  double within_95 = 0.0;
};

/// @brief Normalised error squared of a plane: chi-square with three degrees of freedom if its covariance is right. Of two
/// turns and of the offset at the true region's centroid, taken to its plane: elsewhere it is not linear in the turns.
/// @return infinite if the covariance has no inverse there.
double normalisedErrorSquared(const PlanarRegion& truth, const PlanarRegion& found);

/// @brief Compares the planes of matched regions. @param truth,found planes by id, ascending; regions without one are left
/// out.
PlaneScore planeScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& found,
                      const RegionOverlap& overlap, const SegcompScore& matches);

/// @brief The same for fits to the true pixels: the error that the data leave to any method. @param refits planes fitted to
/// the pixels of the true regions, by id, ascending.
PlaneScore refitScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& refits,
                      const RegionOverlap& overlap, const SegcompScore& matches);

}  // namespace ppc
