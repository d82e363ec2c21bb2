// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/evaluation/segcomp.h"

#include <vector>

namespace ppc {

/// @brief How far polygons' outlines are from the true ones.
struct BoundaryScore {
  int regions = 0;          ///< correct regions that have a polygon
  double mean_error = 0.0;  ///< mean over them of the mean distance of the true outline's points from the rings [m]
};

/// @brief Points of a region's true outline: half-way between each of its pixels and each 4-neighbour outside of it (or the
/// border of the image, half a pixel out), the beam there cut with the region's plane.
///
/// Enclosed gaps of fewer than `min_hole` pixels are no outline. Beams that meet the plane at less than 3 deg are left out:
/// a pixel there is metres long.
std::vector<Eigen::Vector3d> trueOutline(const BeamGrid& beams, const LabelImage& truth, const PlanarRegion& region,
                                         int min_hole = 50);

/// @brief Distance of every point of the true outlines of correct regions from the nearest ring, outer or hole, of the found
/// region's polygons. @param truth_planes planes of the true regions by id, ascending.
BoundaryScore boundaryScore(const BeamGrid& beams, const LabelImage& truth, const std::vector<PlanarRegion>& truth_planes,
                            const std::vector<PlanarPolygon>& polygons, const RegionOverlap& overlap,
                            const SegcompScore& matches);

}  // namespace ppc
