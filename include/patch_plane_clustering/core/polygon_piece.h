// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/kept_list.h"
#include "patch_plane_clustering/core/ring_crossings.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief A polygon with holes in plane coordinates: outer ring counter-clockwise, then the holes, clockwise; not repeated
/// at the end.
struct PolygonPiece {
  KeptList<std::vector<Eigen::Vector2d>> rings;
  double area = 0.0;  ///< outer less holes [m^2]
};

/// @brief Outlines of a piece on its plane: the outer one first; holes have at least 3 points.
using Outlines = KeptList<std::vector<OutlinePoint>>;

/// @brief Working memory of makePiece(), which one piece after the other may use.
struct PieceMemory {
  KeptList<SimplifiedRing> rings;
  KeptList<std::vector<Eigen::Vector2d>> positions;  ///< of their vertices
  std::vector<double> areas;                         ///< of the outlines, signed [m^2]
  std::vector<std::size_t> edges;
  SimplificationMemory simplification;
  CrossingMemory crossings;
};

/// @brief Simplifies the rings of one connected piece and makes sure that they bound it: simple, apart from each other,
/// holes inside. Where simplified rings meet, their edges are refined until they do not. The area stays within four per cent
/// of that of the full rings: where it would not, the tolerance is halved.
/// @param piece overwritten.
/// @return false if the outer ring has less than 3 points, or if even the full rings cross: the piece folds over itself on
/// the plane.
bool makePiece(const Outlines& outlines, const OutlineTolerance& tolerance, PieceMemory& memory, PolygonPiece& piece);

}  // namespace ppc
