// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/label_runs.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Some regions of a label image, and their stretches of pixels.
struct RegionStretches {
  struct Region {
    std::int32_t label;
    std::size_t begin, end;  ///< its stretches
  };
  std::vector<Region> regions;          ///< in the order of their labels
  std::vector<PixelStretch> stretches;  ///< region by region, in scan order
  std::vector<std::size_t> next;        ///< working memory: where the next stretch of each label goes

  /// @param runs of the image, in scan order. @param labels count of labels, 0 among them. @param wanted wanted(label):
  /// whether it is one of these regions; the same whenever it is asked.
  template <typename F>
  void list(const std::vector<LabelRun>& runs, std::size_t labels, F&& wanted) {
    next.assign(labels, 0);
    for (const LabelRun& run : runs) ++next[run.label];
    regions.clear();
    std::size_t end = 0;
    for (std::int32_t label = 1; label < static_cast<std::int32_t>(labels); ++label) {
      if (next[label] == 0 || !wanted(label)) continue;
      const std::size_t begin = end;
      end += next[label];
      next[label] = begin;
      regions.push_back({label, begin, end});
    }
    stretches.resize(end);
    for (const LabelRun& run : runs) {
      if (wanted(run.label)) stretches[next[run.label]++] = {run.begin, run.end};
    }
  }
};

}  // namespace ppc
