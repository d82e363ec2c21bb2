// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of thinStandingLines() and labelStandingLines(), which one image after the other may use.
struct StandingLineMemory {
  /// Of the ranges of two lines at a pixel [m].
  struct Difference {
    std::int32_t label;
    float range;
    int pixel;
  };
  std::vector<float> angles;    ///< between the beams of two lines, beam by beam [rad]
  std::vector<double> steps;    ///< of every line from the one before, negative if not known [rad]
  std::vector<double> known;    ///< those that are
  std::vector<int> kept;        ///< lines of `grid`: their numbers in the image
  std::vector<int> beams;       ///< the numbers of all beams of a line
  std::vector<int> stands_for;  ///< for every line of the image: the line of `grid` that is, or stands for, it
  bool in_columns = false;      ///< whether the lines are columns
  std::vector<Difference> differences;
  BeamGrid grid;      ///< the image without lines that were measured while the scanner stood
  LabelImage labels;  ///< of `grid`
};

/// @brief Looks in a cloud for lines, rows or columns, that were measured while the scanner stood, as most do where they
/// turn or wait, and leaves out all of a group but the first one.
///
/// Directions that come from points contain their noise if the beams start anywhere else than at the viewpoint, as those of
/// a laser on a lever arm do: by little, but lines that stand are not apart by any more. Patches of them would find a plane
/// that contains the true beams, so that no noise is left over, and cut the surfaces that they cross in two. Where a motor
/// goes in steps of a few lines, patches reach over several steps and nothing is lost.
/// @return whether there are any; then memory.grid is the image without them.
bool thinStandingLines(const BeamGrid& grid, StandingLineMemory& memory);

/// @brief Labels of the whole image from memory.labels: lines that were left out have those of the line that stands for
/// them, where both have measured about the same range, as differences on the same surface tell.
/// @param grid and memory as thinStandingLines() left them.
void labelStandingLines(const BeamGrid& grid, StandingLineMemory& memory, LabelImage& labels);

}  // namespace ppc
