// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

namespace ppc {

/// @brief Paints whole patches: their pixels with a measurement get the patch's label, all others 0.
/// @param patches of all blocks. @param shares with one label a patch at most, see shareClusters().
void patchLabels(const BeamGrid& grid, const PatchGrid& patches, const CellShares& shares, LabelImage& out, int threads = 1);

}  // namespace ppc
