// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/polygon_piece.h"

#include "patch_plane_clustering/core/ring_crossings.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace patch_plane_clustering {
namespace {

// Share of its area that a ring may gain or lose by simplification.
constexpr double kOuterAreaChange = 0.02;
constexpr double kHoleAreaChange = 0.2;  // of the hole's own area, a small part of the polygon's

SimplifiedRing simplify(const std::vector<OutlinePoint>& points, OutlineTolerance tolerance, double area_change) {
  const double area = signedArea(points.data(), points.size());
  for (int attempt = 0; attempt < 4; ++attempt) {
    SimplifiedRing ring(points.data(), points.size(), tolerance);
    if (std::abs(ring.area() - area) <= area_change * std::abs(area)) return ring;
    tolerance.metres *= 0.5;
    tolerance.pixels *= 0.5;
  }
  return SimplifiedRing(points.data(), points.size(), OutlineTolerance{});
}

// Refines edges that cross until none do; false if the full rings cross.
bool pullApart(std::vector<SimplifiedRing>& rings, std::vector<std::vector<Eigen::Vector2d>>& positions) {
  std::vector<std::size_t> edges;
  for (;;) {
    const std::vector<RingEdge> crossings = findCrossings(positions);
    if (crossings.empty()) return true;
    bool closer = false;
    for (std::size_t i = 0; i < crossings.size();) {
      const std::size_t ring = crossings[i].ring;
      edges.clear();
      for (; i < crossings.size() && crossings[i].ring == ring; ++i) edges.push_back(crossings[i].edge);
      if (!rings[ring].refine(edges)) continue;
      positions[ring] = rings[ring].positions();
      closer = true;
    }
    if (!closer) return false;
  }
}

}  // namespace

std::optional<PolygonPiece> makePiece(const std::vector<std::vector<OutlinePoint>>& rings,
                                      const OutlineTolerance& tolerance) {
  std::vector<SimplifiedRing> simplified;
  std::vector<std::vector<Eigen::Vector2d>> positions;
  const double turn = signedArea(rings.front().data(), rings.front().size());
  for (std::size_t i = 0; i < rings.size(); ++i) {
    SimplifiedRing ring = simplify(rings[i], tolerance, i == 0 ? kOuterAreaChange : kHoleAreaChange);
    // Within the tolerance a hole may shrink to a line, which bounds nothing.
    if (i > 0 && (ring.size() < 3 || !(ring.area() * turn < 0.0))) continue;
    positions.push_back(ring.positions());
    simplified.push_back(std::move(ring));
  }
  if (simplified.front().size() < 3 || !pullApart(simplified, positions)) return std::nullopt;

  PolygonPiece piece;
  const double outer_area = signedArea(positions.front());
  if (!(outer_area * turn > 0.0)) return std::nullopt;
  piece.area = std::abs(outer_area);
  piece.outer = std::move(positions.front());
  if (outer_area < 0.0) std::reverse(piece.outer.begin(), piece.outer.end());
  for (std::size_t i = 1; i < positions.size(); ++i) {
    std::vector<Eigen::Vector2d>& hole = positions[i];
    const double area = signedArea(hole);
    const auto swallows = [&](const std::vector<Eigen::Vector2d>& other) { return isInside(hole.front(), other); };
    // Rings are apart now, so one vertex tells on which side a ring lies.
    if (!swallows(piece.outer) || std::any_of(piece.holes.begin(), piece.holes.end(), swallows)) continue;
    if (area > 0.0) std::reverse(hole.begin(), hole.end());
    piece.area -= std::abs(area);
    piece.holes.push_back(std::move(hole));
  }
  return piece;
}

}  // namespace patch_plane_clustering
