// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace ppc {

/// Edges of rings that do not share a vertex keep at least this distance [m]: rings stay simple when they are rounded to the
/// single precision of geometry_msgs/Point32.
constexpr double kRingClearance = 1e-5;

/// @brief An edge of one of several rings, from vertex `edge` to the next.
struct RingEdge {
  std::size_t ring = 0;
  std::size_t edge = 0;
};

/// Two edges of one ring that meet, by their indices: first < second.
using EdgePair = std::pair<std::size_t, std::size_t>;

/// @brief An edge with what the search for crossings needs of it.
struct RingSegment {
  Eigen::Vector2d a, b;
  double min_x, max_x, min_y, max_y;
  RingEdge id;
  bool bad;
};

/// @brief Working memory of the search for crossings, which one polygon after the other may use.
struct CrossingMemory {
  std::vector<RingSegment> segments;
  std::vector<std::pair<double, std::size_t>> order;  ///< segments by their smallest x
  std::vector<std::size_t> active;                    ///< those that the sweep line may still meet
  std::vector<RingEdge> found;
  std::vector<EdgePair> pairs;
};

/// @brief All edges that cross, touch or nearly touch (kRingClearance) another edge of the same or another ring, double back
/// on the edge next to them, or are shorter than the clearance.
/// @return in ascending order of ring and edge, unique; empty if the rings are simple and apart. Sweeps over x: O(n log n)
/// for outlines whose edges are short compared with the whole.
std::vector<RingEdge> findCrossings(const std::vector<std::vector<Eigen::Vector2d>>& rings);

/// @brief The same of `count` rings. @return memory.found.
const std::vector<RingEdge>& findCrossings(const std::vector<Eigen::Vector2d>* rings, std::size_t count,
                                           CrossingMemory& memory);

/// @brief The pairs of edges for which findCrossings() finds fault with a single ring, ascending. Edges that are too short
/// have no partner and are left out. @return memory.pairs.
const std::vector<EdgePair>& findMeetingEdges(const std::vector<Eigen::Vector2d>& ring, CrossingMemory& memory);

/// @brief True if `p` lies inside a simple ring of either orientation.
bool isInside(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& ring);

}  // namespace ppc
