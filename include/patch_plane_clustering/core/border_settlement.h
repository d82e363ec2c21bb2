// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/refinement.h"
#include "patch_plane_clustering/core/run_listing.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstddef>
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

/// @brief Working memory of settleBorders(), which one image after the other may use.
struct BorderMemory {
  struct Kept {  ///< points that a new piece has kept of a piece before
    std::int32_t piece, before;
    int points;
  };

  RefinementMemory contest;
  SplitMemory split;
  std::vector<LabelRun> contested, runs;  ///< of the labels after the contest, and of the new pieces
  std::vector<char> is_region;            ///< whether each piece before is, or is part of, a region that is large enough
  std::vector<char> has_region;           ///< of each label
  std::vector<Kept> kept;                 ///< by piece and piece before
  std::vector<std::size_t> latest;        ///< of each new piece in `kept`, plus one
  std::vector<int> taken;                 ///< points that each new piece has of other labels' pieces that bend
  std::vector<std::int32_t> heir;         ///< of each piece before, the new one that shares most points with it
  std::vector<std::int32_t> origin;       ///< of each new piece, the one before that shares most points with it
  std::vector<int> points;                ///< of pieces
  std::vector<std::int32_t> names;        ///< of the new pieces
  std::vector<std::int32_t> own;          ///< the same before soft edges get those of their planes
  std::vector<char> bends;                ///< whether each new piece is one with what bends
  std::vector<LabelRun> settled;          ///< runs of the labels in the end
  RunListMemory listing;
};

/// @brief Settles the borders between regions by their planes as they are after the last merge.
///
/// Borders were drawn with the planes of parts. Here all labels that meet compete once more (contestLabels()); those that
/// are no regions too, but only to defend their own points. What the result means is decided by what was known before:
/// points that keep their label stay of a region or of none, and those that change it are of a region if most of the points
/// that their new piece has kept are. So strips of a curved surface, which no longer bend once they end where their planes
/// meet, do not come back, and no scrap grows into a region. A piece that takes much of what bends, for 0.4 times the points
/// that it has kept of regions less those of none, is a strip of the same surface and no region either; what it has taken of
/// regions goes back, unless nothing of them is left to go back to.
/// @param before the pieces, their names and labels. @param planes of the labels, see labelPlanes().
/// @param smallest points of a region, at least. @param labels those of which `before` has the pieces; set to the new
/// pieces, 0 where there is no region.
/// @param whole set to the label that every new piece is part of; index = piece. @param memory left with the runs of the
/// labels: `settled`.
void settleBorders(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, const LabelPieces& before, int smallest, int gap_rows,
                   int gap_cols, BorderMemory& memory, LabelImage& labels, std::vector<std::int32_t>& whole,
                   int threads = 1);

/// @brief What is left of it after the contest. @param count of labels.
/// @param memory with the runs of the labels after the contest: `contested`. Left as by settleBorders().
void settleContested(int cols, const LabelPieces& before, std::size_t count, int smallest, int gap_rows, int gap_cols,
                     BorderMemory& memory, LabelImage& labels, std::vector<std::int32_t>& whole, int threads);

}  // namespace ppc
