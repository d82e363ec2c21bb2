// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ppc {

/// @brief A polygon with holes in plane coordinates: outer ring counter-clockwise, holes clockwise, not repeated at the end.
struct PolygonPiece {
  std::vector<Eigen::Vector2d> outer;
  std::vector<std::vector<Eigen::Vector2d>> holes;
  double area = 0.0;  ///< outer less holes [m^2]
};

/// @brief Simplifies the rings of one connected piece and makes sure that they bound it: simple, apart from each other,
/// holes inside. Where simplified rings meet, their edges are refined until they do not. The area stays within four per cent
/// of that of the full rings: where it would not, the tolerance is halved.
/// @param outlines outer ring first; holes have at least 3 points.
/// @return nothing if the outer ring has less than 3 points, or if even the full rings cross: the piece folds over itself on
/// the plane.
std::optional<PolygonPiece> makePiece(const std::vector<std::vector<OutlinePoint>>& outlines,
                                      const OutlineTolerance& tolerance);

}  // namespace ppc
