// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/bend.h"
#include "patch_plane_clustering/core/region_samples.h"
#include "patch_plane_clustering/core/similarity.h"

namespace ppc {

/// @brief A region, and how it bends.
struct BentRegion {
  const RegionSamples& region;
  const Bend& bend;
};

/// @brief Whether two touching regions are strips of one curved surface, a fan: well turned against each other, or each bent
/// by about as much as they are; one quadratic surface serves both, and two planes do not four times as well, as at a
/// crease (to a sensor so fine that the tolerance shrinks with its noise, 1.5 times).
/// @param max_turn from which on a region is curved [rad], see planarNames().
bool isFan(const BentRegion& a, const BentRegion& b, const CoplanarityTolerance& tolerance, double max_turn);

/// @brief Whether a strip beside a curved one is more of the same surface: turned against it, and part of one smooth surface
/// with it; at the limb of a cylinder, where beams graze it, less exactly.
bool isMoreOfFan(const BentRegion& strip, const BentRegion& beside, const CoplanarityTolerance& tolerance, double max_turn);

}  // namespace ppc
