// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/distance_variance.h"
#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/pixel_set.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of alignCreases(), which one image after the other may use.
struct CreaseMemory {
  /// A pixel that may be of either label.
  struct Candidate {
    int pixel;
    bool first_farther;  ///< whether its beam meets the plane of the first label behind that of the second
  };
  struct Change {
    int pixel;
    std::int32_t label;
  };
  /// What a thread has for itself.
  struct Worker {
    PixelSet near;                ///< pixels near the border of a pair; empty in between
    std::vector<Candidate> open;  ///< of a pair
  };
  DistanceVariance variance;
  std::vector<std::vector<Change>> changes;  ///< of each pair, and maybe more lists
  std::vector<Worker> workers;
};

/// @brief Draws the borders of regions that meet at a crease along the line where their planes meet.
///
/// Close to a crease both planes are within the noise of a point, so that its own range tells little about which of them it
/// belongs to; the planes, each known from all of its points, tell where they cut each other. On which side of their common
/// line each of them is seen is taken from points near the border, at which the planes are more than the noise apart; where
/// those do not agree (at a step, a picture on a wall, an edge in front of something else) the border is left as it is.
/// A point changes its label only if the planes are within noise of each other along its beam, and it of the other one.
/// @param planes a (see moments.h) of every label. @param meetings of those labels that take part.
void alignCreases(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, const CreaseMeetings& meetings,
                  CreaseMemory& memory, LabelImage& labels, int threads = 1);

}  // namespace ppc
