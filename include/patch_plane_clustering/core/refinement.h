// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/segmentation.h"

namespace patch_plane_clustering {

/// @brief Labels of the pixels of clustered patches: cluster index + 1, 0 elsewhere.
LabelImage patchLabels(const BeamGrid& grid, const PatchGrid& patches, const PatchClusters& clusters);

/// @brief Point-wise labels: patches inside a cluster keep its label, all others are resolved point by point.
///
/// Each candidate plane near a point predicts its range; the likeliest plane wins. The evidence is averaged over a small window
/// (the likelihood of single points overlaps at high noise), outliers capped. Points that no plane explains get 0.
LabelImage refineLabels(const BeamGrid& grid, const PatchGrid& patches, const PatchClusters& clusters, const NoiseModel& noise,
                        const CoplanarityTolerance& tolerance);

/// @brief Splits labels into pieces that are connected in the image. Gaps of up to `gap_cols` columns or `gap_rows` rows are
/// bridged.
void splitComponents(int gap_rows, int gap_cols, LabelImage& labels);

}  // namespace patch_plane_clustering
