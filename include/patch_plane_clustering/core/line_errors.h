// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <vector>

namespace ppc {

/// @brief Range errors that all beams of a line share, one for each row of a grid [m]; empty if there are none to speak of.
///
/// On a plane inverse range is linear in the direction of the beam, so each line is predicted by the two beside it; the
/// median misfit of its beams is what the line is off. From these differences the errors follow by least squares, but for
/// slow changes from line to line, which cannot be told from the shape of the scene. Errors smaller than the noise of single
/// ranges do no harm and are left alone; so are images whose rows are not lines (range cameras).
std::vector<float> estimateLineErrors(const BeamGrid& grid);

}  // namespace ppc
