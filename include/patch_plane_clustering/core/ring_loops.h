// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/ring_crossings.h"

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Corners begin, ..., begin + count - 1 of a ring (indices wrap round).
struct RingLoop {
  std::size_t begin, count;
  std::size_t place;  ///< among those found
};

/// @brief Working memory of cutLoops(), which one ring after the other may use.
struct LoopMemory {
  CrossingMemory crossings;
  std::vector<Eigen::Vector2d> positions;
  std::vector<RingLoop> loops;
  std::vector<OutlinePoint> corners;  ///< of a loop
  std::vector<char> touched, gone;    ///< corners
  std::vector<OutlinePoint> kept;
};

/// @brief Leaves out points that coincide with the one before (at the pole all lines meet).
void dropRepeats(std::vector<OutlinePoint>& ring);

/// @brief Whether a ring is a figure of eight, as that of a piece through the pole of a scan: the image lies the other way
/// round on the plane in one of two loops, which meet at a narrow place and enclose opposite areas. Steps of the corners
/// tell in one pass, where the search for edges that meet takes many.
/// @param share the smaller loop has at least this share of the area of the larger one.
bool foldsOver(const std::vector<OutlinePoint>& ring, double share);

/// @brief Cuts off the loops and spikes at which a ring of corners meets itself, as long as they enclose next to nothing.
///
/// Where beams graze the plane, or lines nearly coincide at the pole, noise puts neighbouring corners into the wrong order:
/// the outline then doubles back on itself, though the region does not.
/// @param max_area largest area of one loop [m^2].
/// @return true if anything was cut; the ring may still meet itself in larger loops.
bool cutLoops(std::vector<OutlinePoint>& ring, double max_area, LoopMemory& memory);

}  // namespace ppc
