// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/evaluation/segcomp.h"

#include <vector>

namespace ppc {

/// @brief Pixels (row-major indices, ascending) of a hole: what a region encloses without being part of it.
using Hole = std::vector<int>;

/// @brief The holes of one region: 4-connected sets of other pixels from which no path leads out of the region's silhouette.
/// @param min_pixels smaller ones are left out: missing measurements. @return in image order.
std::vector<Hole> holesOf(const LabelImage& labels, std::int32_t id, int min_pixels);

/// @brief How many holes of the true regions are holes of the found ones too.
struct HoleScore {
  int true_holes = 0;      ///< in the true regions that count
  int found_holes = 0;     ///< of those: a hole of the found region has an intersection over union of at least 0.5 with it
  int found_openings = 0;  ///< of those: an opening of the found region, be it a hole or a notch of its outline: at least
                           ///< 0.8 of the hole is outside of the region, and at least half of the hole's rim belongs to it
};

/// @brief Compares the holes of every true region of `overlap` with those of the found region that shares most pixels with
/// it.
HoleScore holeScore(const LabelImage& truth, const LabelImage& found, const RegionOverlap& overlap, int min_pixels = 50);

}  // namespace ppc
