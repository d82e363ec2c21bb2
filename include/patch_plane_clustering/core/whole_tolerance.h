// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/similarity.h"

#include <algorithm>

namespace ppc {

/// Radius of a part up to which the tolerance of its angle counts [m].
constexpr double kMaxWholeRadius = 0.5;

/// @brief What two large parts of one plane may differ by, which is more than from patch to patch. @param points of the
/// smaller part. @param sigma noise there [m].
inline CoplanarityTolerance wholeTolerance(const CoplanarityTolerance& tolerance, double sigma, double points) {
  constexpr double kWhole = 1.5;  // distance over that from patch to patch
  CoplanarityTolerance whole = tolerance.forNoise(sigma);
  whole.sigma_distance *= kWhole;
  whole.inflation = tolerance.inflationOf(points);
  return whole;
}

/// @brief The least secantSquared() of a plane for two parts and of the parts' own: a plane across an edge is seen more
/// obliquely than those of both sides, on which the tolerance is to be had.
inline double leastSecantSquared(const PlaneFit& joint, const PlaneFit& a, const PlaneFit& b, double range) {
  return std::min({secantSquared(joint.a, range), secantSquared(a.a, range), secantSquared(b.a, range)});
}

}  // namespace ppc
