// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/lanes.h"

#include <algorithm>
#include <vector>

namespace ppc {

/// Calls visit(pixel) for every pixel of [begin, end) that has a measurement.
template <typename F>
void forEachMeasured(const BeamGrid& grid, int begin, int end, F&& visit) {
  const float* const ranges = grid.range.data();
  for (int i = begin; i < end; i += kLanes) {
    const int count = std::min(kLanes, end - i);
    const Lanes four = count == kLanes ? loadLanes<Lanes>(ranges + i) : loadLanes<Lanes>(ranges + i, count);
    if (!anyLane(four > Lanes{})) continue;  // where nothing was measured
    for (int k = i; k < i + count; ++k) {
      if (grid.valid(k)) visit(k);
    }
  }
}

/// Calls visit(pixel), in order, for the measured pixels before each of the runs [first, last), and for those in such whose
/// label is loose (findLoose()). The run after the last one, runs.size(), stands for the end of the image.
template <typename F>
void forEachLoose(const BeamGrid& grid, const std::vector<LabelRun>& runs, const std::vector<char>& loose, int first,
                  int last, F&& visit) {
  const int count = static_cast<int>(runs.size());
  for (int k = first; k < last; ++k) {
    const int gap = k == 0 ? 0 : runs[k - 1].end, begin = k == count ? grid.size() : runs[k].begin;
    forEachMeasured(grid, gap, begin, visit);
    if (k < count && loose[runs[k].label] != 0) forEachMeasured(grid, begin, runs[k].end, visit);
  }
}

}  // namespace ppc
