// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/border_settlement.h"
#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/label_joining.h"
#include "patch_plane_clustering/core/label_meetings.h"
#include "patch_plane_clustering/core/label_pairs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/row_runs.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of reuniteLabels(), which one image after the other may use.
struct ReunionMemory {
  RowRuns rows;
  LabelPairIndex index;
  std::vector<LabelPair> touching;
  std::vector<char> has_region;  ///< whether each label has a piece that is a planar region
  std::vector<Moments> sums;     ///< of the labels
  std::vector<JoinCandidate> candidates;
  std::vector<std::int32_t> names;  ///< of the labels
};

/// @brief Makes one label of two that touch only since borders were contested, and have one plane: what lay between them, a
/// scrap with a plane of its own, has gone to both, and no merge comes after that.
///
/// Labels that met when they were merged last were judged there, where they meet, and stay apart, as do those that were
/// split since. For the others the planes of the wholes must hardly differ (misfit() of 0.7 at most, with the tolerance of
/// patches, not the wider one of wholes): most similar first, each time with the planes of what has been joined.
/// Thread-safe with memory of one's own.
/// @param shares of the labels before the contest. @param met groups of the last merge, in ascending keys, by the labels'
/// names after it. @param merged labels that were there then: higher ones are newer.
/// @param pieces before the contest; labels without a planar region among them, as what bends, are left alone. `whole` is
/// brought up to date. @param runs of the labels after the contest, in an image of rows x cols; renamed.
/// @param planes of the labels; those that others have joined get the joint plane.
void reuniteLabels(int rows, int cols, const CellShares& shares, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, const std::vector<MeetingGroup>& met, std::int32_t merged,
                   ReunionMemory& memory, LabelPieces& pieces, std::vector<LabelRun>& runs,
                   std::vector<Eigen::Vector3d>& planes);

}  // namespace ppc
