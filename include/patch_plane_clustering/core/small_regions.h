// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/label_runs.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

namespace ppc {

/// @brief Regions of a label image that have few points, and their stretches of pixels.
struct SmallRegions {
  static constexpr int kMostPoints = 4000;  ///< single pixels turn the planes of larger ones little

  struct Region {
    std::int32_t label;
    std::size_t begin, end;  ///< its stretches
  };
  std::vector<Region> regions;          ///< in the order of their labels
  std::vector<PixelStretch> stretches;  ///< region by region, in scan order
  std::vector<LabelRun> runs;           ///< the same, with labels
  std::vector<int> points;              ///< of each label of the image

  /// Lists those of `smallest` to kMostPoints pixels. @param all runs of the labels; not `runs`.
  void list(const std::vector<LabelRun>& all, int smallest) {
    points.assign(static_cast<std::size_t>(highestLabel(all)) + 1, 0);
    for (const LabelRun& run : all) points[run.label] += run.end - run.begin;
    runs.clear();
    std::copy_if(all.begin(), all.end(), std::back_inserter(runs),
                 [&](const LabelRun& run) { return points[run.label] >= smallest && points[run.label] <= kMostPoints; });
    sortByLabel(runs);
    stretches.clear();
    for (const LabelRun& run : runs) stretches.push_back({run.begin, run.end});
    regions.clear();
    forEachLabel(runs, [&](std::int32_t label, std::size_t begin, std::size_t end) {
      regions.push_back({label, begin, end});
    });
  }
};

}  // namespace ppc
