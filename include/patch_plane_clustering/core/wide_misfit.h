// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/grid_lines.h"
#include "patch_plane_clustering/core/line_misfit.h"

#include <vector>

namespace ppc {

/// @brief Working memory of measureWideMisfit(), which one line after the other may use.
struct WideMisfitMemory {
  std::vector<float> errors;   ///< of the beams of a sector
  std::vector<float> sectors;  ///< middle error of each
};

/// @brief What all ranges of a line are off against those of the lines `reach` before and after it: its own error less the
/// weighted ones of theirs.
///
/// Planes that are seen over so many lines tell slow changes from line to line, which hardly show between neighbours
/// (measureLineMisfit()). A beam moves on a cone about the axis, so it is predicted by the same beam of the two lines and by
/// what changes along its own line. Where an edge of the scene runs along the lines, a part of a line agrees upon a wrong
/// error: each sector of the line has its say, and how far sectors disagree is in the deviation.
/// @param line at least `reach` from the first and the last.
/// @param spread of what single beams are off between neighbouring lines [m]; beams off by more than three times as much
/// lie on no plane, so errors should be known that well before.
/// @return the range and the weights; no samples if too few sectors tell, or the lines are too far apart.
LineMisfit measureWideMisfit(const GridLines& lines, int line, int reach, double spread, WideMisfitMemory& memory);

}  // namespace ppc
