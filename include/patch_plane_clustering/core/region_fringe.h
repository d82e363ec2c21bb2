// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/row_runs.h"

#include <array>
#include <vector>

namespace ppc {

/// @brief Working memory of offFringe(), which one region after the other may use.
struct FringeMemory {
  std::vector<LabelRun> runs;              ///< of the region
  RowRuns rows;                            ///< the same, cut at rows
  std::array<std::vector<int>, 4> fringe;  ///< pixels whose neighbour above, below, before, after is not of the region
  std::vector<int> off;                    ///< pixels of parts that are off
  std::vector<PixelStretch> stretches;     ///< the same, neighbours joined
};

/// @brief Finds those parts of a region's fringe that lie off its plane to one side.
///
/// Where a border is drawn a pixel too far, points of what is beside the region lie along it: each of them within the noise,
/// and all of them on the same side. A few hundredths of a region turn its plane by several degrees if it is as narrow as
/// the noise is large, like the riser of a stair. The fringe on each of four sides is looked at in parts of about 16
/// pixels; a part is off if the mean of its errors, each capped at `limit`, is more than three of its standard deviations
/// from 0. No single error decides, so that what is left has a distribution of errors as wide as before.
/// @param begin,end blocks of the region, in scan order. @param plane of the region. @param sigma standard deviation of the
/// errors as ErrorScale weighs them [m]. @param scale the limit and how errors count.
/// @return the pixels of such parts, in scan order; each once. In `memory`.
const std::vector<PixelStretch>& offFringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end,
                                           const Plane& plane, double sigma, const ErrorScale& scale, FringeMemory& memory);

}  // namespace ppc
