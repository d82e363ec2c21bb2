// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_joining.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/moments.h"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of reuniteRegions(), which one image after the other may use.
struct RegionReunionMemory {
  std::vector<char> wanted;               ///< labels that are in one
  std::vector<Moments> sums;              ///< of those labels
  std::vector<JoinCandidate> candidates;  ///< excesses of chi-square, and up to which they are joined
  std::vector<std::int32_t> names;        ///< of the labels
};

/// @brief Makes one region of two that touch and have one plane: chi-square of a plane through the points of both exceeds
/// that of one through each by no more than 20, and noise makes it 3; by 60, where their planes are on average within .15
/// standard deviations of each other along the border, as points there have been given to the nearer one.
///
/// They come to touch late, as borders are drawn and regions extended after the last merge (mergeLabels(), reuniteLabels()):
/// the two parts of a wall on either side of a pane, once what is seen of it beside the pane is no longer the pane's. Only
/// regions that meet at five places or more, where their planes are within .4 standard deviations on average and not turned
/// by ten degrees, are looked at; only points within four standard deviations of each region's plane count, which half of
/// its points must be.
/// For errors that are not correlated (CoplanarityTolerance::isWhite()). Deterministic; thread-safe with memory of one's
/// own.
/// @param meetings of the labels. @param runs of the labels, as the meetings.
/// @param planes a (see moments.h) of every label; those that others have joined get the joint plane.
/// @param labels the higher label of two becomes the lower one. @return whether any did.
bool reuniteRegions(const JudgedImage& image, const CreaseMeetings& meetings, const std::vector<LabelRun>& runs,
                    RegionReunionMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels);

}  // namespace ppc
