// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace patch_plane_clustering {

struct PolygonOptions {
  double simplification_tolerance = 0.02;  ///< largest distance between the outline and its simplification [m]; 0 = keep all
  int min_hole_size = 20;                  ///< holes of fewer pixels than this are filled
};

/// @brief Outlines of the labelled regions as polygons with holes on their planes.
///
/// The outline runs along pixel corners (through centres it would lose half a pixel a side); the beam through each corner is
/// cut with the plane, so edges carry no range noise. Every polygon returned is simple, its holes lie inside, do not overlap,
/// and the number of vertices is reduced within the tolerance. A region that no simple ring can bound (it reaches round the
/// pole of the scan, or touches itself) comes as several polygons of the same id.
/// @param regions as made by describeRegions() from the same labels.
/// @return polygons in ascending id, larger pieces first.
std::vector<PlanarPolygon> extractPolygons(const BeamGrid& grid, const LabelImage& labels,
                                           const std::vector<PlanarRegion>& regions, const PolygonOptions& options);

}  // namespace patch_plane_clustering
