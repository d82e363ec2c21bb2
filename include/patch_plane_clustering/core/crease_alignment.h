// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of alignCreases(), which one image after the other may use.
struct CreaseMemory {
  /// A place where two labels, first < second, are next to each other: at `pixel` and one row or column before it.
  struct Meeting {
    std::int32_t first, second;
    int pixel, step;  ///< step: 1 along a row, the number of columns along a column
  };
  /// A pixel near a border of two labels.
  struct Candidate {
    int pixel;
    bool first_farther;  ///< whether its beam meets the plane of the first label behind that of the second
    bool witness;        ///< whether the planes are clearly apart there
    bool open;           ///< whether it may be of either
  };
  struct Change {
    int pixel;
    std::int32_t label;
  };
  std::vector<int> points;        ///< of each label
  std::vector<Meeting> meetings;  ///< by pairs of labels
  std::vector<int> seen;          ///< pixels: number of the pair that has looked at them last
  std::vector<Candidate> near;    ///< of one pair
  std::vector<Change> changes;
};

/// @brief Draws the borders of regions that meet at a crease along the line where their planes meet.
///
/// Close to a crease both planes are within the noise of a point, so that its own range tells little about which of them it
/// belongs to; the planes, each known from all of its points, tell where they cut each other. On which side of their common
/// line each of them is seen is taken from points near the border, at which the planes are more than the noise apart; where
/// those do not agree (at a step, a picture on a wall, an edge in front of something else) the border is left as it is.
/// A point changes its label only if the planes are within noise of each other along its beam, and it of the other one.
/// @param planes a (see moments.h) of every label. @param center origin of the planes [m].
/// @param smallest points that a region has at least; others take no part.
void alignCreases(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
                  const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, CreaseMemory& memory,
                  LabelImage& labels);

}  // namespace ppc
