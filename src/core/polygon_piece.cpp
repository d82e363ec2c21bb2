// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/polygon_piece.h"

#include "patch_plane_clustering/core/ring_crossings.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ppc {
namespace {

using Outlines = std::vector<std::vector<OutlinePoint>>;

constexpr int kAttempts = 5;                 // each with half the tolerance of the one before, the last with none
constexpr double kLargestAreaChange = 0.02;  // of the polygon's area

SimplifiedRing simplify(const std::vector<OutlinePoint>& points, double area, OutlineTolerance tolerance,
                        double area_change) {
  for (int attempt = 1; attempt < kAttempts; ++attempt) {
    SimplifiedRing ring(points.data(), points.size(), tolerance);
    if (std::abs(ring.area() - area) <= area_change) return ring;
    tolerance = tolerance.halved();
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

// Rings of one polygon, once they are apart, in the order of the outlines; false if a hole is not where it was.
bool nested(const std::vector<std::vector<Eigen::Vector2d>>& rings) {
  for (std::size_t i = 1; i < rings.size(); ++i) {
    const Eigen::Vector2d& p = rings[i].front();  // no ring crosses another: one vertex tells
    if (!isInside(p, rings.front())) return false;
    for (std::size_t j = 1; j < rings.size(); ++j) {
      if (j != i && isInside(p, rings[j])) return false;
    }
  }
  return true;
}

PolygonPiece assemble(std::vector<std::vector<Eigen::Vector2d>> rings) {
  PolygonPiece piece;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const double area = signedArea(rings[i]);
    if ((area > 0.0) != (i == 0)) std::reverse(rings[i].begin(), rings[i].end());
    piece.area += i == 0 ? std::abs(area) : -std::abs(area);
    (i == 0 ? piece.outer : piece.holes.emplace_back()) = std::move(rings[i]);
  }
  return piece;
}

}  // namespace

std::optional<PolygonPiece> makePiece(const Outlines& outlines, const OutlineTolerance& tolerance) {
  if (outlines.empty() || outlines.front().size() < 3) return std::nullopt;
  std::vector<double> areas;  // signed
  for (const auto& outline : outlines) areas.push_back(signedArea(outline.data(), outline.size()));
  double area = std::abs(areas.front());
  for (std::size_t i = 1; i < areas.size(); ++i) area -= std::abs(areas[i]);
  area = std::max(area, 0.0);

  OutlineTolerance current = tolerance;
  for (int attempt = 1; attempt <= kAttempts; ++attempt, current = current.halved()) {
    const bool last = attempt == kAttempts || tolerance.none();
    if (last) current = {};
    std::vector<SimplifiedRing> rings;
    std::vector<std::vector<Eigen::Vector2d>> positions;
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      // A small hole may change by more, as long as the polygon hardly notices.
      const double own = kLargestAreaChange * std::abs(areas[i]);
      const double change =
          i == 0 ? kLargestAreaChange * area : std::max(own, std::min(10.0 * own, 0.1 * kLargestAreaChange * area));
      rings.push_back(simplify(outlines[i], areas[i], current, change));
      positions.push_back(rings.back().positions());
    }
    if (!pullApart(rings, positions)) return std::nullopt;  // the full rings cross
    if (!nested(positions)) {
      if (last) return std::nullopt;
      continue;
    }
    PolygonPiece piece = assemble(std::move(positions));
    if (last || std::abs(piece.area - area) <= 2.0 * kLargestAreaChange * area) return piece;
  }
  return std::nullopt;
}

}  // namespace ppc
