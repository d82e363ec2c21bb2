// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <vector>

namespace ppc {

/// @brief The image of some rows and columns of an image, in the order given; empty if there are none of either.
/// @param rows, cols numbers from 0 to before grid.rows and grid.cols; not checked. @param out overwritten, its memory used
/// again; not `grid` itself.
void selectBeams(const BeamGrid& grid, const std::vector<int>& rows, const std::vector<int>& cols, BeamGrid& out);

}  // namespace ppc
