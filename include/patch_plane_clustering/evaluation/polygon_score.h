// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <string>
#include <vector>

namespace ppc {

/// @brief Renders polygons back along every beam: the id of the nearest polygon that the beam goes through, 0 = none. Beams
/// without a measurement are rendered too; see withoutUnmeasured().
/// @param regions their planes are those of the polygons with the same id.
LabelImage renderPolygons(const BeamGrid& beams, const std::vector<PlanarRegion>& regions,
                          const std::vector<PlanarPolygon>& polygons);

/// @brief The labels with 0 where the grid has no measurement. @throws std::invalid_argument if the sizes differ.
LabelImage withoutUnmeasured(const BeamGrid& grid, LabelImage labels);

/// @brief What can be said about polygons without a truth.
struct PolygonQuality {
  int polygons = 0;
  int holes = 0;
  int vertices = 0;
  int invalid = 0;                 ///< not simple, wrongly nested, not finite, empty, or rings in the wrong sense
  std::string first_fault;         ///< of the first invalid one
  double largest_off_plane = 0.0;  ///< largest distance of a vertex from its plane [m]
};

/// @brief Bytes of the points over bytes of the polygons: 12 a point and a vertex (three floats), 32 a plane (four doubles),
/// 4 a ring (its length). 0 without polygons.
double compression(int points, const PolygonQuality& quality);

/// @brief Checks every polygon on its plane: finite, simple, holes inside and apart, outer ring counter-clockwise and holes
/// clockwise seen from the sensor (against the normal).
PolygonQuality polygonQuality(const std::vector<PlanarRegion>& regions, const std::vector<PlanarPolygon>& polygons);

}  // namespace ppc
