// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <vector>

namespace ppc {

/// @brief Working memory of clearStrays(), which one image after the other may use.
struct StrayMemory {
  std::vector<float> ranges;  ///< of one round
  BeamGrid grid;              ///< the image without strays
};

/// @brief Looks for strays: single points that lie nowhere near their neighbours, as dust, rain, sunlight and edges make
/// them. A point is one if, of its eight neighbours but one, each is farther than the point is by more than 10 cm and 3 % of
/// the range, or each is nearer: more than noise, or steps of the range, make of any sensor's neighbours. So points of a
/// surface seen at a grazing angle are none, nor are those of a line, but for its ends. Points at the border of the image or
/// of what has been measured are none either; there too few neighbours tell.
///
/// Points that are none of a surface are left without a label in any case; but where some in a hundred are strays,
/// most patches contain some, hence fit no plane, and those are worst off that are large, towards the pole of the scan.
/// @return whether there are that many, by a sample of rows (never in images of less than 8 rows or columns); then
/// memory.grid is the image without them.
bool clearStrays(const BeamGrid& grid, StrayMemory& memory, int threads = 1);

}  // namespace ppc
