// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/judged_image.h"

#include <Eigen/Core>

namespace ppc {

/// @brief How far the planes of two regions are from each other along the beams where the regions meet, on average.
struct PlaneDistance {
  int meetings = 0;            ///< places where they do: a pixel may meet two neighbours
  double in_sigmas = 0.0;      ///< in standard deviations of the noise and of CoplanarityTolerance::sigma_distance
  double in_tolerances = 0.0;  ///< in CoplanarityTolerance::sigma_distance alone
};

/// @brief Whether planes are turned by less than ten degrees.
inline bool areAlmostParallel(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a.dot(b) >= 0.985 * a.norm() * b.norm();
}

/// @brief Measures it. Infinite if no beam there tells. @param a,b planes (see moments.h).
PlaneDistance distanceAt(const JudgedImage& image, const CreaseMeetings& meetings, const CreaseMeetings::Pair& pair,
                         const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace ppc
