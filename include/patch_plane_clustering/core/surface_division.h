// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/surface_cut.h"

#include <vector>

namespace ppc {

/// @brief For every cell of a region, those that share an edge with it: cells[begin[i]] to before cells[begin[i + 1]].
struct SurfaceLinks {
  std::vector<int> begin, cells;
};

/// @brief A region's cells divided between two planes.
struct SurfaceDivision {
  static constexpr double kEdge = 3.0;  ///< chi-square that an edge between both sides costs

  double gain = 0.0;         ///< chi-square of one plane less that of two
  int border = 0;            ///< edges between cells on both sides
  std::vector<char> beyond;  ///< for every cell, whether it lies on the second one; empty if there is no division

  /// What counts: a border that winds through noise explains noise.
  double score() const { return gain - kEdge * border; }
};

/// @brief Working memory of divideSurface(), which one region after the other may use.
struct DivisionMemory {
  std::vector<float> misfits, weights, sums;  ///< of cells and of those around them
  std::vector<char> side;                     ///< of a division that is tried
  std::vector<int> patch;                     ///< of each cell: which connected patch it is in
  std::vector<int> members, patch_begin;      ///< cells, patch by patch
};

/// @brief Divides the cells of a region between two planes where no straight cut does: a door in a wall, an L of two faces.
///
/// From three starts (the straight cut, what stands before the region's plane, and what stands behind it), in turns: a plane
/// is fitted to each side, and each cell goes to the one that explains it better, where each neighbour on a side speaks for
/// that side with 3 in chi-square, as a Potts model has it (iterated conditional modes, Besag 1986); when nothing changes
/// any more, or after eight rounds, patches that lie apart go over unless they gain 15 by staying. The best start's by
/// score() is taken.
/// @param cut the best of the region, see bestCut(). @param fewest points that each side must have.
void divideSurface(const std::vector<SurfaceCell>& cells, const SurfaceLinks& links, const SurfaceCut& cut, double fewest,
                   DivisionMemory& memory, SurfaceDivision& division);

}  // namespace ppc
