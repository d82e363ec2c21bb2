// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/line_sums.h"
#include "patch_plane_clustering/core/outline_excess.h"

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace ppc {

/// @brief A corner of an outline that stays, and where.
struct RingVertex {
  std::size_t corner = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  bool moved = false;  ///< off its corner
};

/// @brief Working memory of SimplifiedRing, which one ring after the other may use.
struct SimplificationMemory {
  LineSums sums;
  std::vector<char> chosen;                               ///< corners
  std::vector<std::pair<std::size_t, std::size_t>> open;  ///< stretches that may need another corner
  std::vector<Line> lines;                                ///< of the edges
  std::vector<std::size_t> far;                           ///< edges
  std::vector<RingVertex> added;
};

/// @brief A closed ring of corners reduced to few vertices.
///
/// Corners are chosen by Douglas & Peucker (1973); each edge is then moved onto the least-squares line through the midpoints
/// of the pixel sides that it stands for, and a vertex onto the intersection of its two edges, so that the staircase of the
/// pixels leaves no bias. Every corner stays within the tolerance of the edge that replaces it.
class SimplifiedRing {
 public:
  /// @param points at least 3; must outlive what is asked of the ring. Memory is used again.
  void setPoints(const OutlinePoint* points, std::size_t size);

  void simplify(const OutlineTolerance& tolerance, SimplificationMemory& memory);

  std::size_t size() const { return vertices_.size(); }
  const Eigen::Vector2d& vertex(std::size_t i) const { return vertices_[i].position; }
  void positions(std::vector<Eigen::Vector2d>& out) const;

  /// Signed area, positive if counter-clockwise [m^2].
  double area() const;

  /// @brief Brings some edges closer to the corners they stand for: moves their vertices back onto corners or, where these
  /// are already there, adds the corner farthest from the edge. Repeated, it leads to the full ring.
  /// @param edges indices of edges, edge i from vertex i to the next; ascending and unique.
  /// @return false if none of them could be brought closer.
  bool refine(const std::vector<std::size_t>& edges, SimplificationMemory& memory);

 private:
  std::size_t next(std::size_t vertex) const { return vertex + 1 == vertices_.size() ? 0 : vertex + 1; }
  std::pair<std::size_t, double> farthest(std::size_t edge, double least) const;
  void chooseCorners(SimplificationMemory& memory);
  void mergeStraightEdges(const LineSums& sums);
  void moveOntoLines(SimplificationMemory& memory);
  void keepTolerance(SimplificationMemory& memory);
  void putBack(RingVertex& vertex) const;

  const OutlinePoint* points_ = nullptr;
  std::size_t n_ = 0;
  OutlineExcess excess_;
  std::vector<RingVertex> vertices_;  // in ascending order of corners
};

/// @brief Signed area of a ring, positive if counter-clockwise [m^2].
double signedArea(const OutlinePoint* points, std::size_t size);
double signedArea(const std::vector<Eigen::Vector2d>& ring);

}  // namespace ppc
