// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

/// @brief Moves the vertices of neighbouring polygons onto the common line of their planes, where their border runs along
/// it, so that both faces of an edge meet.
///
/// The labels cannot tell two planes apart nearer to their line than the noise divided by the sine of the angle between
/// them; vertices within twice that, two tolerances and a pixel are moved to the nearest point of the line, or to the corner
/// of three planes. Planes that turn by less than 5 deg have no line worth the name. A ring that would not stay simple, in
/// its place and of about its area is left as it was. Deterministic, thread-safe.
/// @param regions, polygons as of extractPolygons() from the same labels. @param tolerance of the outlines [m].
/// @param pixel_tolerance the same in pixels.
void snapCreases(const BeamGrid& grid, const LabelImage& labels, const std::vector<PlanarRegion>& regions, double tolerance,
                 double pixel_tolerance, std::vector<PlanarPolygon>& polygons);

}  // namespace ppc
