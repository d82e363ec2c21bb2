// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/region_samples.h"

namespace ppc {

constexpr double kBendSignificance = 25.0;  ///< of an excess: far beyond chi-square with 3 degrees of freedom

/// @brief How a region bends: the quadratic surface z = c0 + c1 s + c2 t + c3 s^2 + c4 s t + c5 t^2 over its own plane.
struct Bend {
  double turn = 0.0;       ///< angle between the normals at its two ends, along the direction of strongest curvature [rad]
  double excess = 0.0;     ///< chi-square of the plane less that of the quadratic surface (3 degrees of freedom)
  double amplitude = 0.0;  ///< root mean square of the quadratic part [m]
  double chi2 = 0.0;       ///< of the samples about their own plane
  double weight = 0.0;     ///< of the samples, sum of 1 / variance [1/m^2]
  Plane plane;             ///< of the samples along their beams: without the bias of total least squares in much noise
};

/// @brief Fits the surface to a region's samples.
Bend bendOf(const RegionSamples& region);

}  // namespace ppc
