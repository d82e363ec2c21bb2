// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief What the labels have in every cell of a grid of patches. Nine cells in ten are one label's whole: their moments
/// stay where they are, and what is asked of all cells again and again are a few bytes of each.
struct CellShares {
  static constexpr int kWhole = -1;

  std::vector<int> begin;            ///< index of each cell's first share, and one past the last
  std::vector<std::int32_t> only;    ///< for every cell its only label, 0 if it has none, -1 if it has several
  std::vector<std::int32_t> labels;  ///< of every share, cell by cell
  std::vector<int> parts;            ///< of every share: index of its moments, or kWhole: those of the cell are its own
  std::vector<Moments> moments;      ///< of parts of cells, weighed with the noise; there may be some that no share has
  std::vector<Moments> sums;         ///< of every label over all cells; index = label

  /// Moments of a share of a cell. @param cells those that have been shared.
  const Moments& momentsOf(const PatchGrid& cells, int cell, int share) const {
    return parts[share] == kWhole ? cells.patches[cell].moments : moments[parts[share]];
  }
};

/// @brief Working memory of updateShares(), which one image after the other may use.
struct ShareMemory {
  struct Part {
    std::vector<int> cells;           ///< that have changed
    std::vector<std::int32_t> found;  ///< labels in one of them
  };

  CellShares before;
  std::vector<CellShares> rest;  ///< of the cells of each thread but the first
  std::vector<Part> parts;       ///< of each thread's cells
  std::vector<int> points;       ///< of each label before
  std::vector<char> again;       ///< whether a label is summed anew
};

/// @brief Moments of the labels in every cell, about cells.center. @param cells with weighed moments (weighPatches).
CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                      int threads = 1);

/// @brief The same where clusters of patches were made labels, index + 1: nothing needs to be summed.
void shareClusters(const PatchClusters& clusters, CellShares& shares);

/// @brief The same, where the shares before some change of labels are known. @param changed for every cell: whether its
/// labels may have changed since. Sums of labels are kept, less what those cells had and with what they have: equal to those
/// summed anew but for rounding.
/// @param shares those before; brought up to date. @param memory overwritten.
void updateShares(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                  const std::vector<char>& changed, CellShares& shares, ShareMemory& memory, int threads = 1);

/// @brief Renames the labels of the shares and adds up those that have become one in a cell.
/// @param names index = label: itself, or a lower label that keeps its name.
void renameShares(const std::vector<std::int32_t>& names, CellShares& shares);

/// @brief Planes of the labels: a (see moments.h); index = label.
std::vector<Eigen::Vector3d> labelPlanes(const CellShares& shares);
/// @brief The same into planes that are there, whose memory is used again.
void labelPlanes(const CellShares& shares, std::vector<Eigen::Vector3d>& planes);

/// @brief Whether several labels meet in a cell, or it lies next to a cell with another label.
/// @param only see CellShares.
inline bool isBorderCell(const PatchGrid& cells, const std::vector<std::int32_t>& only, int cell) {
  const std::int32_t label = only[cell];
  if (label <= 0) return label < 0;
  const int* const end = cells.neighbours.data() + cells.neighbour_begin[cell + 1];
  return std::any_of(cells.neighbours.data() + cells.neighbour_begin[cell], end,
                     [&](int j) { return only[j] != 0 && only[j] != label; });
}

}  // namespace ppc
