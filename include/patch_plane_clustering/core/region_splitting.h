// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/label_split.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"
#include "patch_plane_clustering/core/surface_cut.h"
#include "patch_plane_clustering/core/surface_division.h"

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
  struct Work {                         ///< of one thread
    std::vector<SurfaceCell> surface;
    LabelSplit cut;
    SurfaceLinks links;
    DivisionMemory dividing;
    SurfaceDivision division;
    std::vector<int> index;  ///< of each cell of the grid among those of a part, -1 if it has none
  };
  std::vector<Work> works;
  std::vector<LabelSplit> splits;  ///< of the parts that are labels
  LabelSplit side_split;           ///< of one that is a side
  std::vector<char> found;         ///< for each label: whether there is one
};

/// @brief Splits labels that have swallowed a piece of another plane, as a face may its small neighbour that nothing else
/// competes for: along the straight cut after which a plane on each side explains most, or by a division of the cells
/// between two planes (divideSurface()): a door in a wall, an L of two faces of a box.
///
/// Cuts are straight in the image or, where none there will do, on the label's plane (bestCutOnPlane()): long creases are
/// bent in the image of a tilting scanner. Curved surfaces have better cuts on the plane as well, so that those must
/// explain 1.5 times what one quadratic surface does, and exceed it by twice as much.
/// A label is split if two planes explain it far better than one, and than one quadratic surface: that is for the test of
/// curvature; if their misfit is beyond the tolerance; and if they leave little to explain. Where errors are correlated,
/// that is what noise may leave after a straight cut. Where they are not, there may be more planes, and up to three times
/// what the cut explains may be left.
/// Divisions, which could follow noise, are taken where there is no such cut or they explain twice as much (of more than 300
/// cells, more); are for errors that are not correlated, where misfits over whole cells tell of a second plane; must score
/// more (1.3 times what a quadratic surface explains, 2.2 if their sides are not parallel) and leave less (what noise may,
/// or 0.3 times what they explain); and their border must not wind, as it does along lines that are off. What is left is
/// counted in misfits of whole cells, not of points, unless points within cells show that more than a tenth of the noise's
/// variance is wrong: of many points, a small error of the noise leaves more than any third plane. Sides are split again.
/// Labels of more than 300 cells are split only where errors are not correlated and misfits over whole cells tell of a
/// second plane, and, but for creases beyond doubt, only into parallel sides, as walls bow: by divisions, or by a straight
/// cut that explains 1.4 times as much as a quadratic surface, if chi-square is 3 % above what noise leaves.
///
/// Some divisions of labels of any size are beyond doubt, and taken also where the misfit is within the tolerance. At a
/// crease of 2.3 degrees and more, as between a floor and a ramp that was merged with it, one quadratic surface leaves ten
/// times as much beyond two planes as noise may, and these leave no more than noise may, or .05 of that if it is more; for a
/// sensor so fine that the tolerance shrinks with its noise (CoplanarityTolerance::forNoise()), four times as much and .15
/// do from 4 degrees on. To such a sensor, there is a low step of parallel sides if cells on both sides of the border
/// already differ by 0.6 of the tolerance, which most waves and bows do not, though as much as 0.6 of what the division
/// explains may be left for a third level.
///
/// Where noise is smooth (CoplanarityTolerance::isSmooth(), or alike_around), labels of any size are divided after a merge,
/// with chi-square over the inflation of the smallest side so that borders do not follow bumps of noise, if the best
/// straight cut explains .03 of what the label's plane leaves. Beyond a quadratic surface, the division must explain 30
/// times the inflation of its smaller side, and as much as this leaves; leave, a point, no more than four times as much on
/// the smaller side as on the other or as noise does; be a misfit beyond the tolerance; and its sides must be turned by 8
/// degrees, or the smaller one leave ten times as much on the other's plane. This alone is done there if `merged`;
/// where noise is neither white nor smooth, nothing is.
/// @param cells with weighed moments. @param merged whether labels may have been merged since they were last looked at.
/// @param smallest points of a label; a side has a quarter at least.
/// @param shares of `labels`. Both are brought up to date: new labels follow the last of shares.sums.
/// @return whether any was split.
bool splitLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance, int smallest, bool merged, LabelSplitMemory& memory,
                 CellShares& shares, LabelImage& labels, int threads = 1);

}  // namespace ppc
