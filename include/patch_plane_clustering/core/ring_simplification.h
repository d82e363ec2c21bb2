// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/outline_excess.h"

#include <Eigen/Core>
#include <vector>

namespace ppc {

class LineSums;

/// @brief A closed ring of corners reduced to few vertices.
///
/// Corners are chosen by Douglas & Peucker (1973); each edge is then moved onto the least-squares line through the midpoints
/// of the pixel sides that it stands for, and a vertex onto the intersection of its two edges, so that the staircase of the
/// pixels leaves no bias. Every corner stays within the tolerance of the edge that replaces it.
class SimplifiedRing {
 public:
  /// @param points at least 3; must outlive the object.
  SimplifiedRing(const OutlinePoint* points, std::size_t size, const OutlineTolerance& tolerance);

  std::size_t size() const { return vertices_.size(); }
  const Eigen::Vector2d& vertex(std::size_t i) const { return vertices_[i].position; }
  std::vector<Eigen::Vector2d> positions() const;

  /// Signed area, positive if counter-clockwise [m^2].
  double area() const;

  /// @brief Brings some edges closer to the corners they stand for: moves their vertices back onto corners or, where these
  /// are already there, adds the corner farthest from the edge. Repeated, it leads to the full ring.
  /// @param edges indices of edges, edge i from vertex i to the next; ascending and unique.
  /// @return false if none of them could be brought closer.
  bool refine(const std::vector<std::size_t>& edges);

 private:
  struct Vertex {
    std::size_t corner = 0;
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    bool moved = false;  // off its corner
  };

  std::size_t next(std::size_t vertex) const { return vertex + 1 == vertices_.size() ? 0 : vertex + 1; }
  std::pair<std::size_t, double> farthest(std::size_t edge) const;
  void chooseCorners();
  void mergeStraightEdges(const LineSums& sums);
  void moveOntoLines(const LineSums& sums);
  void keepTolerance();
  void putBack(Vertex& vertex) const;

  const OutlinePoint* points_;
  std::size_t n_;
  OutlineExcess excess_;
  std::vector<Vertex> vertices_;  // in ascending order of corners
};

/// @brief Signed area of a ring, positive if counter-clockwise [m^2].
double signedArea(const OutlinePoint* points, std::size_t size);
double signedArea(const std::vector<Eigen::Vector2d>& ring);

}  // namespace ppc
