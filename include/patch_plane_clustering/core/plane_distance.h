// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/judged_image.h"

#include <Eigen/Core>

namespace ppc {

/// @brief How far the planes of two regions are from each other along the beams where the regions meet, on average.
struct PlaneDistance {
  int meetings = 0;            ///< pixels of one region that have a neighbour of the other
  double in_sigmas = 0.0;      ///< in standard deviations of the noise and of CoplanarityTolerance::sigma_distance
  double in_tolerances = 0.0;  ///< in CoplanarityTolerance::sigma_distance alone
};

/// @brief Measures it. Infinite if no beam there tells. @param a,b planes (see moments.h).
PlaneDistance distanceAt(const JudgedImage& image, const CreaseMeetings& meetings, const CreaseMeetings::Pair& pair,
                         const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace ppc
