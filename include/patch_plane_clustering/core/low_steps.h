// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of settleLowSteps(), which one image after the other may use.
struct LowStepMemory {
  struct Step {
    int pair;       ///< its place among the meetings' pairs
    int meetings;   ///< pixels of one label that have a neighbour of the other
    double height;  ///< mean distance of the planes along the beams there, in standard deviations
  };
  std::vector<Step> steps;
  std::vector<char> wanted;                   ///< labels that have a step, and whose planes are fitted again
  std::vector<Moments> sums;                  ///< of those labels: points that are near the plane that each had at first
  std::vector<Eigen::Vector3d> first_planes;  ///< of the labels
  /// Of a rectangle of pixels: what tells for the second label, and which label each has; both over windows.
  std::vector<float> evidence, of_first, of_second, evidence_around, first_around, second_around, columns;
};

/// @brief Draws the borders of regions that meet at a step which noise hides from single points: a pane in its wall, a door
/// a little behind it, seen by a sensor whose noise is as large.
///
/// The few points that a border is drawn with elsewhere (CellResolver) do not tell planes apart that are less than a
/// standard deviation from each other, along the beams: borders wind there, and where a wall is narrow beside a pane, it is
/// given to the pane, and so falls in two. That is for labels that meet at 15 places or more, whose planes are turned by
/// less than ten degrees and stand apart there, on average, by less than the noise (with
/// CoplanarityTolerance::sigma_distance) and by more than twice that tolerance alone, which walls may bow; all this as it is
/// before any border moves.
///
/// Each point near the border asks a window of so many points that they tell: the log-likelihood ratio of the two planes
/// over it, each point's capped, is 8 on average. Where it is below 2.5, as along the line where planes cross, points stay
/// what they are. Borders with more meetings come first; each is drawn twice, and planes are fitted again each time, to the
/// points near those that they were at first, but for labels of more than 16384 points, which a few do not turn.
///
/// For errors that are not correlated (CoplanarityTolerance::isWhite()). Deterministic; thread-safe with memory of one's
/// own.
/// @param meetings of the labels. @param runs of the labels, as the meetings.
/// @param rows_per_column rows that span the angle of a column [1].
/// @param planes a (see moments.h) of every label; those of labels whose borders move are set anew.
/// @return whether any pixel has changed its label.
bool settleLowSteps(const JudgedImage& image, const CreaseMeetings& meetings, const std::vector<LabelRun>& runs,
                    double rows_per_column, LowStepMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels);

}  // namespace ppc
