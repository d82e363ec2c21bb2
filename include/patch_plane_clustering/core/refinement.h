// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/cell_resolver.h"
#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/labels_around.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of refineLabels() and contestLabels(), which one image after the other may use.
struct RefinementMemory {
  struct alignas(64) OfThread {  ///< written all the time: in cache lines of its own
    ResolverMemory resolver;
    AroundMemory around;
    std::vector<int> cells;
  };

  std::vector<std::int32_t> whole;  ///< of every cell, see refineLabels()
  std::vector<char> open;           ///< likewise
  BlockLabels blocks;
  std::vector<OfThread> of_thread;
};

/// @brief Resolves labels point by point, as sharp as the image: cells inside a region keep its label, in all others the
/// planes seen in and near the cell compete for each point.
///
/// Each candidate plane predicts the point's range; the likeliest plane wins. The evidence is averaged over a small window
/// (the likelihoods of single points overlap at high noise), outliers capped. Points that no plane explains get 0.
/// @param cells blocks of pixels, with the shares of the labels in each (shareCells). @param planes see labelPlanes().
/// @param first_open pixels with a label below this one keep it; 1 resolves all.
/// @param labels the labels of which `shares` tells; resolved in place.
/// @param changed set for each cell: whether its labels have changed.
void refineLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                  const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                  std::int32_t first_open, RefinementMemory& memory, LabelImage& labels, std::vector<char>& changed,
                  int threads = 1);

/// @brief Lets labels that meet compete once more for the points near their borders, as in refineLabels().
///
/// For planes that are known better than when the borders were drawn. Points that no plane explains keep their label.
void contestLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, RefinementMemory& memory, LabelImage& labels, int threads = 1);

}  // namespace ppc
