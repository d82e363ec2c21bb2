// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"
#include "patch_plane_clustering/core/surface_cut.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of splitLabels(), which one image after the other may use.
struct LabelSplitMemory {
  struct Place {  ///< of a label: a share of a cell
    int cell, share;
  };
  struct Part {  ///< places [begin, end) have the label
    std::int32_t label;
    int begin, end;
  };
  std::vector<int> count, begin, next;  ///< cells of each label; its first place, and one past the last; the next to fill
  std::vector<Place> places, leaving;   ///< label by label; those of the side that gets a new label
  std::vector<Part> parts;              ///< to be looked at
  struct Side {
    Moments sum;
    PlaneFit fit;
  };
  struct Split {
    SurfaceCut cut;
    Side low, high;
  };
  std::vector<std::vector<SurfaceCell>> surfaces;  ///< of a part; one a thread
  std::vector<Split> splits;                       ///< of the parts that are labels
  std::vector<char> found;                         ///< for each of these: whether there is one
};

/// @brief Splits labels that have swallowed a piece of another plane, as a face may its small neighbour that nothing else
/// competes for: along the straight cut after which a plane on each side explains most.
///
/// A label is split if two planes explain it far better than one, and than one quadratic surface: that is for the test of
/// curvature; if their misfit is beyond the tolerance; and if they leave little to explain. Where errors are correlated,
/// that is what noise may leave; where they are not, there may be more planes, and up to three times what the cut explains
/// may be left. Sides are split again. Labels of more than 300 cells are looked at only where errors are not correlated and
/// their chi-square is more than 3 % above what noise leaves. A label, or a side, of so many cells is split only into sides
/// that are parallel and explain 1.4 times as much as a quadratic surface: a low step is all that so much swallows, and
/// walls bow.
/// @param cells with weighed moments. @param smallest points of a label; a side has a quarter at least.
/// @param shares of `labels`. Both are brought up to date: new labels follow the last of shares.sums.
/// @return whether any was split.
bool splitLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance, int smallest, LabelSplitMemory& memory, CellShares& shares,
                 LabelImage& labels, int threads = 1);

}  // namespace ppc
