// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of one thread that paints patches.
struct PatchRow {
  std::vector<int> next, end;        ///< of each strip: its next block, and the row where the one before it ends
  std::vector<std::int32_t> labels;  ///< of the blocks at a row
};

/// @brief Paints whole patches: their pixels with a measurement get the patch's label, all others 0.
/// @param patches of all blocks. @param shares with one label a patch at most, see shareClusters().
/// @param memory one a thread, overwritten.
void patchLabels(const BeamGrid& grid, const PatchGrid& patches, const CellShares& shares, std::vector<PatchRow>& memory,
                 LabelImage& out, int threads = 1);

}  // namespace ppc
