// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/polygon_piece.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ppc {
namespace {

using FlatRings = KeptList<std::vector<Eigen::Vector2d>>;

constexpr int kAttempts = 5;                 // each with half the tolerance of the one before, the last with none
constexpr double kLargestAreaChange = 0.02;  // of the polygon's area

void simplify(double area, OutlineTolerance tolerance, double area_change, SimplificationMemory& memory,
              SimplifiedRing& ring) {
  for (int attempt = 1; attempt < kAttempts; ++attempt) {
    ring.simplify(tolerance, memory);
    if (std::abs(ring.area() - area) <= area_change) return;
    tolerance = tolerance.halved();
  }
  ring.simplify(OutlineTolerance{}, memory);
}

// Refines edges that cross until none do; false if the full rings cross.
bool pullApart(PieceMemory& memory) {
  std::vector<std::size_t>& edges = memory.edges;
  for (;;) {
    const std::vector<RingEdge>& crossings =
        findCrossings(memory.positions.begin(), memory.positions.size(), memory.crossings);
    if (crossings.empty()) return true;
    bool closer = false;
    for (std::size_t i = 0; i < crossings.size();) {
      const std::size_t ring = crossings[i].ring;
      edges.clear();
      for (; i < crossings.size() && crossings[i].ring == ring; ++i) edges.push_back(crossings[i].edge);
      if (!memory.rings[ring].refine(edges, memory.simplification)) continue;
      memory.rings[ring].positions(memory.positions[ring]);
      closer = true;
    }
    if (!closer) return false;
  }
}

// Rings of one polygon, once they are apart, in the order of the outlines; false if a hole is not where it was.
bool nested(const FlatRings& rings) {
  for (std::size_t i = 1; i < rings.size(); ++i) {
    const Eigen::Vector2d& p = rings[i].front();  // no ring crosses another: one vertex tells
    if (!isInside(p, rings[0])) return false;
    for (std::size_t j = 1; j < rings.size(); ++j) {
      if (j != i && isInside(p, rings[j])) return false;
    }
  }
  return true;
}

void assemble(FlatRings& rings, PolygonPiece& piece) {
  piece.rings.clear();
  piece.area = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const double area = signedArea(rings[i]);
    if ((area > 0.0) != (i == 0)) std::reverse(rings[i].begin(), rings[i].end());
    piece.area += i == 0 ? std::abs(area) : -std::abs(area);
    piece.rings.add() = rings[i];
  }
}

}  // namespace

bool makePiece(const Outlines& outlines, const OutlineTolerance& tolerance, PieceMemory& memory, PolygonPiece& piece) {
  if (outlines.empty() || outlines[0].size() < 3) return false;
  std::vector<double>& areas = memory.areas;
  areas.clear();
  memory.rings.clear();
  for (const std::vector<OutlinePoint>& outline : outlines) {
    areas.push_back(signedArea(outline.data(), outline.size()));
    memory.rings.add().setPoints(outline.data(), outline.size());
  }
  double area = std::abs(areas.front());
  for (std::size_t i = 1; i < areas.size(); ++i) area -= std::abs(areas[i]);
  area = std::max(area, 0.0);

  OutlineTolerance current = tolerance;
  for (int attempt = 1; attempt <= kAttempts; ++attempt, current = current.halved()) {
    const bool last = attempt == kAttempts || tolerance.none();
    if (last) current = {};
    memory.positions.clear();
    for (std::size_t i = 0; i < areas.size(); ++i) {
      // A small hole may change by more, as long as the polygon hardly notices.
      const double own = kLargestAreaChange * std::abs(areas[i]);
      const double change =
          i == 0 ? kLargestAreaChange * area : std::max(own, std::min(10.0 * own, 0.1 * kLargestAreaChange * area));
      simplify(areas[i], current, change, memory.simplification, memory.rings[i]);
      memory.rings[i].positions(memory.positions.add());
    }
    if (!pullApart(memory)) return false;  // the full rings cross
    if (!nested(memory.positions)) {
      if (last) return false;
      continue;
    }
    assemble(memory.positions, piece);
    if (last || std::abs(piece.area - area) <= 2.0 * kLargestAreaChange * area) return true;
  }
  return false;
}

}  // namespace ppc
