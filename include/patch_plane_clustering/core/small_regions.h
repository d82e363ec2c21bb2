// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/region_stretches.h"

#include <vector>

namespace ppc {

/// @brief Regions of so few points that some pixels of others turn their planes.
struct SmallRegions : RegionStretches {
  static constexpr int kMostPoints = 4000;

  std::vector<int> points;  ///< of each label of the image

  /// Lists those of `smallest` to kMostPoints pixels. @param runs of the labels, in scan order.
  void list(const std::vector<LabelRun>& runs, int smallest) {
    const std::size_t labels = static_cast<std::size_t>(highestLabel(runs)) + 1;
    countPoints(runs, labels, points);
    RegionStretches::list(runs, labels,
                          [&](std::int32_t label) { return points[label] >= smallest && points[label] <= kMostPoints; });
  }
};

}  // namespace ppc
