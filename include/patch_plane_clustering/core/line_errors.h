// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/line_misfit.h"
#include "patch_plane_clustering/core/wide_misfit.h"

#include <vector>

namespace ppc {

/// @brief Errors that all beams of a scan line share.
struct LineErrors {
  bool in_columns = false;    ///< lines are the columns of the grid, not its rows
  std::vector<double> range;  ///< one for each line: ranges are too long by this [m]; empty: none to speak of
  double range_left = 0.0;    ///< standard deviation of what is left of those errors without these, about [m]
  std::vector<double> turn;   ///< one for each line: the beams truly point this much further on towards the next lines than
                              ///< their directions say [rad]; empty: none to speak of

  bool empty() const { return range.empty() && turn.empty(); }
};

/// @brief Working memory of estimateLineErrors(), which one image after the other may use.
struct LineErrorMemory {
  std::vector<LineMisfit> misfits;          ///< of each line
  std::vector<LineMisfitMemory> of_thread;  ///< one a thread
  std::vector<LineMisfit> wide;             ///< of each line, against lines farther off
  std::vector<WideMisfitMemory> wide_of_thread;
  std::vector<double> sizes, spreads, deviations, slopes, uneven;
  std::vector<LineOff> off;  ///< of each line
  BeamGrid corrected;
};

/// @brief Errors of range and of tilt that each line has for itself: a range that drifts, an encoder of coarse steps, play
/// in the gears.
///
/// On a plane inverse range is linear in the direction of the beam, so each line is predicted by the two beside it. What its
/// beams are off follows a line's error of range alike, and one of tilt in proportion to the slope of range over tilt;
/// both are fitted robustly. From these differences the errors follow by least squares, but for slow changes from line to
/// line, which cannot be told from the shape of the scene. Those of range are made out over up to 40 lines to either side
/// (measureWideMisfit()). Errors of less than a third of the noise of single ranges (of tilt: that make less than half of
/// it) do no harm and are left alone; so are images that were not taken line by line (range cameras). Lines are the rows of
/// a range image; those of a cloud are its rows or, if these show no errors, its columns.
LineErrors estimateLineErrors(const BeamGrid& grid, LineErrorMemory& memory, int threads = 1);

/// @brief The same without memory.
LineErrors estimateLineErrors(const BeamGrid& grid, int threads = 1);

/// @brief Takes the errors out of the ranges, and turns the beams to where they pointed. @param out overwritten.
void removeLineErrors(const LineErrors& errors, const BeamGrid& grid, BeamGrid& out);

}  // namespace ppc
