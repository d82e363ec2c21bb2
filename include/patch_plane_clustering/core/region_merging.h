// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief What the labels have in every cell of a grid of patches.
struct CellShares {
  struct Share {
    std::int32_t label;
    Moments moments;  ///< of the label's pixels in the cell, weighed with the noise
  };
  std::vector<int> begin;     ///< index of each cell's first share, and one past the last
  std::vector<Share> shares;  ///< cell by cell
};

/// @brief Moments of the labels in every cell, about cells.center. @param cells with weighed moments (weighPatches).
CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                      int threads = 1);

/// @brief The same where clusters of patches were made labels, index + 1: nothing needs to be summed.
void shareClusters(const PatchGrid& patches, const std::vector<int>& cluster_of, CellShares& shares);

/// @brief The same, where the shares before some change of labels are known. @param changed for every cell: whether its
/// labels may have changed since.
/// @param shares those before; brought up to date. @param memory overwritten.
void updateShares(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                  const std::vector<char>& changed, CellShares& shares, CellShares& memory, int threads = 1);

/// @brief Planes of the labels: a (see moments.h); index = label.
std::vector<Eigen::Vector3d> labelPlanes(const CellShares& cells);

/// @brief The labels of every cell in arrays of their own: shares are large, and most of what is asked of them is the label.
struct CellLabels {
  const std::vector<int>& begin;     ///< see CellShares, which must outlive this
  std::vector<std::int32_t> labels;  ///< cell by cell
  std::vector<std::int32_t> only;    ///< for every cell its only label, 0 if it has none, -1 if it has several

  explicit CellLabels(const CellShares& shares, int threads = 1);
};

/// @brief Whether several labels meet in a cell, or it lies next to a cell with another label.
/// @param only see CellLabels.
inline bool isBorderCell(const PatchGrid& cells, const std::vector<std::int32_t>& only, int cell) {
  const std::int32_t label = only[cell];
  if (label <= 0) return label < 0;
  const int* const end = cells.neighbours.data() + cells.neighbour_begin[cell + 1];
  return std::any_of(cells.neighbours.data() + cells.neighbour_begin[cell], end,
                     [&](int j) { return only[j] != 0 && only[j] != label; });
}

/// @brief Merges labels that touch and lie on one plane, most similar first.
///
/// Two conditions must hold. The joint plane serves both as wholes: with a wider tolerance than from patch to patch, for
/// walls bow, wider still if they are hardly turned against each other; or they are turned a little, but the border itself
/// lies on one plane rather than on the two (a sagging floor, not a crease). And where they meet there is no step: the
/// strips on both sides of the border are compared by their offset alone (a plane tilted across a step hides three quarters
/// of it); those of a wide bow, whose joint plane leaves the border, by the nearest of both sides.
/// @param cells blocks of pixels by which "touching" and "where they meet" are measured.
/// @param shares of `labels`; renamed along with them. @param planes set to those of the new labels, as by labelPlanes(); 0
/// of names that no label has any more. @return the runs of the new labels.
std::vector<LabelRun> mergeLabels(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                  double threshold, CellShares& shares, LabelImage& labels,
                                  std::vector<Eigen::Vector3d>& planes, int threads = 1);

/// @brief The same where there is no image of the labels yet. @return the new name of every label.
std::vector<std::int32_t> mergeShares(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double threshold, CellShares& shares, std::vector<Eigen::Vector3d>& planes,
                                      int threads = 1);

}  // namespace ppc
