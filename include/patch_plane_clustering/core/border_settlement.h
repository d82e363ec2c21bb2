// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/region_merging.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Connected pieces of labels, and what was made of them.
struct LabelPieces {
  std::vector<LabelRun> runs;       ///< of the pieces
  std::vector<std::int32_t> whole;  ///< for every piece the label that it is part of; index = piece, 0 for 0
  /// For every piece itself, 0 if it is no planar region, or another piece that it is given to (see planarNames()).
  std::vector<std::int32_t> names;
};

/// @brief Settles the borders between regions by their planes as they are after the last merge.
///
/// Borders were drawn with the planes of parts. Here all labels that meet compete once more (contestLabels()); those that
/// are no regions too, but only to defend their own points. What the result means is decided by what was known before:
/// points that keep their label stay of a region or of none, and those that change it are of a region if most of the points
/// that their new piece has kept are. So strips of a curved surface, which no longer bend once they end where their planes
/// meet, do not come back, and no scrap grows into a region.
/// @param before the pieces, their names and labels. @param planes of the labels, see labelPlanes().
/// @param smallest points of a region, at least. @param labels those of which `before` has the pieces; set to the new
/// pieces, 0 where there is no region.
/// @return for every new piece the label that it is part of; index = piece.
std::vector<std::int32_t> settleBorders(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                                        const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                                        const CoplanarityTolerance& tolerance, const LabelPieces& before, int smallest,
                                        int gap_rows, int gap_cols, LabelImage& labels, int threads = 1);

}  // namespace ppc
