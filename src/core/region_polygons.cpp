// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_polygons.h"

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/crease_snapping.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/polygon_memory.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <algorithm>
#include <boost/geometry/algorithms/convex_hull.hpp>
#include <boost/geometry/geometries/multi_point.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/ring.hpp>
#include <boost/geometry/strategies/strategies.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace ppc {
namespace {

// A piece that is still not simple after so many cuts has beams without order and is dropped.
constexpr int kMaxCuts = 12;

// A piece is seen edge-on if the beams through more than this share of its outline meet the plane nowhere near the points.
constexpr double kEdgeOn = 1.0 / 3.0;

// A loop of an outline may be cut off if it encloses no more than this share of the outline's area.
constexpr double kLoopShare = 2e-3;

// An outline folds if both of its loops enclose more than this share of the larger one's area: none that could be cut off.
constexpr double kFold = 10.0 * kLoopShare;

// Smallest area of a polygon [m^2].
constexpr double kMinArea = 1e-8;

class RegionOutliner {
 public:
  RegionOutliner(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region, const PolygonOptions& options,
                 OutlineMemory& memory)
      : grid_(grid), labels_(labels), id_(region.id), projection_(grid, labels, region), options_(options), memory_(memory) {
    tolerance_.metres = std::max(0.0, options.simplification_tolerance);
    if (tolerance_.metres > 0.0) tolerance_.pixels = std::max(0.0, options.pixel_tolerance);
    memory.pieces.clear();
    memory.parts.resize(kMaxCuts);
  }

  /// Adds the piece bounded by these rings; in several parts where one will not do.
  void add(const std::vector<PixelCorner>& corners, const PixelPiece& rings, int cuts) {
    Outlines& outlines = memory_.outlines;
    outlines.clear();
    std::size_t limited = 0;
    for (const PixelRing& ring : rings) {
      const std::size_t before = projection_.limited();
      std::vector<OutlinePoint>& outline = outlines.add();
      project(corners, ring, outline);
      if (outlines.size() == 1) limited = projection_.limited() - before;
      if (outline.size() >= 3) continue;
      outlines.dropLast();
      if (!ring.hole) return;
    }
    const std::size_t outer_corners = rings.outer().end - rings.outer().begin;
    PolygonPiece& piece = memory_.pieces.add();
    const bool folded = cuts == 0 && foldsOver(outlines[0], kFold);
    bool made = !folded && (makePiece(outlines, tolerance_, memory_.piece, piece) || makePieceWithoutLoops(piece));
    if (!made && static_cast<double>(limited) > kEdgeOn * static_cast<double>(outer_corners)) {
      maskPiece(corners, rings, memory_.mask);
      outlines.clear();
      hullOf(memory_.mask, outlines.add());
      made = makePiece(outlines, tolerance_, memory_.piece, piece);
    }
    if (!made || !(piece.area > kMinArea)) memory_.pieces.dropLast();
    if (!made && cuts < kMaxCuts) cut(corners, rings, cuts + 1);
  }

  void liftTo(std::int32_t id, KeptList<PlanarPolygon>& polygons) {
    const KeptList<PolygonPiece>& pieces = memory_.pieces;
    std::vector<std::size_t>& order = memory_.order;
    order.resize(pieces.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return pieces[a].area != pieces[b].area ? pieces[a].area > pieces[b].area : a < b;
    });
    for (const std::size_t k : order) {
      const KeptList<std::vector<Eigen::Vector2d>>& rings = pieces[k].rings;
      PlanarPolygon& polygon = polygons.add();
      polygon.id = id;
      polygon.area = pieces[k].area;
      lift(rings[0], polygon.outer);
      polygon.holes.resize(rings.size() - 1);
      for (std::size_t i = 1; i < rings.size(); ++i) lift(rings[i], polygon.holes[i - 1]);
    }
  }

 private:
  // Corners on the plane; those that coincide count once.
  void project(const std::vector<PixelCorner>& corners, const PixelRing& ring, std::vector<OutlinePoint>& outline) {
    outline.resize(ring.end - ring.begin);
    projection_.project(corners.data() + ring.begin, outline.size(), outline.data());
    dropRepeats(outline);
  }

  // Beams along a plane do not tell where on it an outline runs; the points do, about.
  void hullOf(const PieceMask& mask, std::vector<OutlinePoint>& outline) const {
    namespace bg = boost::geometry;
    using Point = bg::model::d2::point_xy<double>;
    bg::model::multi_point<Point> points;
    for (int r = 0; r < mask.labels.rows; ++r) {
      for (int c = 0; c < mask.labels.cols; ++c) {
        const int i = grid_.index(mask.row + r, mask.col + c);
        if (mask.labels.labels[r * mask.labels.cols + c] == 0 || labels_.labels[i] != id_ || !grid_.valid(i)) continue;
        const Eigen::Vector2d p = projection_.flatten(mask.row + r, mask.col + c);
        points.emplace_back(p.x(), p.y());
      }
    }
    bg::model::ring<Point, false, false> hull;
    bg::convex_hull(points, hull);
    outline.assign(hull.size(), OutlinePoint());
    for (std::size_t i = 0; i < hull.size(); ++i) outline[i].point = {hull[i].x(), hull[i].y()};
    dropRepeats(outline);
  }

  bool makePieceWithoutLoops(PolygonPiece& piece) {
    Outlines& outlines = memory_.outlines;
    if (outlines.empty()) return false;
    const double area = std::abs(signedArea(outlines[0].data(), outlines[0].size()));
    bool shorter = false;
    for (std::vector<OutlinePoint>& outline : outlines) shorter |= cutLoops(outline, kLoopShare * area, memory_.loops);
    return shorter && makePiece(outlines, tolerance_, memory_.piece, piece);
  }

  void cut(const std::vector<PixelCorner>& corners, const PixelPiece& rings, int cuts) {
    PieceMask& mask = memory_.mask;
    maskPiece(corners, rings, mask);
    const bool folds = cuts == 1 && splitAtFolds(projection_, mask, memory_.folds);
    if (!folds && !splitInHalf(mask)) return;
    OutlineMemory::Parts& parts = memory_.parts[static_cast<std::size_t>(cuts - 1)];
    traceContours(mask.labels, memory_.contours, parts.contours);
    for (PixelCorner& corner : parts.contours.corners) {
      corner.row += mask.row;
      corner.col += mask.col;
    }
    ringsByComponent(parts.contours, options_.min_hole_size, parts.pieces);
    const int fewest = std::min(options_.min_hole_size, rings.outer().pixels / 4);
    for (const PixelPiece& part : parts.pieces.pieces) {
      if (part.outer().pixels >= fewest) add(parts.contours.corners, part, cuts);
    }
  }

  void lift(const std::vector<Eigen::Vector2d>& ring, std::vector<Eigen::Vector3d>& lifted) const {
    lifted.clear();
    lifted.reserve(ring.size());
    for (const auto& p : ring) lifted.push_back(projection_.lift(p));
  }

  const BeamGrid& grid_;
  const LabelImage& labels_;
  std::int32_t id_;
  CornerProjection projection_;
  const PolygonOptions& options_;
  OutlineTolerance tolerance_;
  OutlineMemory& memory_;
};

void requireFit(const BeamGrid& grid, const LabelImage& labels) {
  if (labels.rows == grid.rows && labels.cols == grid.cols && labels.labels.size() == grid.range.size()) return;
  throw std::invalid_argument("label image of " + std::to_string(labels.rows) + " x " + std::to_string(labels.cols) +
                              " pixels does not fit the grid of " + std::to_string(grid.rows) + " x " +
                              std::to_string(grid.cols));
}

}  // namespace

std::vector<PlanarPolygon> extractPolygons(const BeamGrid& grid, const LabelImage& labels,
                                           const std::vector<PlanarRegion>& regions, const PolygonOptions& options,
                                           int threads) {
  PolygonMemory memory;
  std::vector<PlanarPolygon> polygons;
  extractPolygons(grid, labels, labelRuns(labels), regions, options, memory, polygons, threads);
  return polygons;
}

void extractPolygons(const BeamGrid& grid, const LabelImage& labels, const std::vector<LabelRun>& runs,
                     const std::vector<PlanarRegion>& regions, const PolygonOptions& options, PolygonMemory& memory,
                     std::vector<PlanarPolygon>& polygons, int threads) {
  requireFit(grid, labels);
  traceOutlines(labels, runs, options, memory);
  makePolygons(grid, labels, regions, options, memory, polygons, threads);
}

void traceOutlines(const LabelImage& labels, const std::vector<LabelRun>& runs, const PolygonOptions& options,
                   PolygonMemory& memory) {
  traceContours(labels, runs, memory.tracing, memory.contours);
  ringsByComponent(memory.contours, options.min_hole_size, memory.pieces);
  // By label, then by size: the largest part of a region is kept however small it is. Of equal ones the first comes first.
  std::vector<PixelPiece>& pieces = memory.pieces.pieces;
  std::sort(pieces.begin(), pieces.end(), [](const PixelPiece& a, const PixelPiece& b) {
    const PixelRing &first = a.outer(), &second = b.outer();
    if (first.label != second.label) return first.label < second.label;
    return first.pixels != second.pixels ? first.pixels > second.pixels : a.first < b.first;
  });
}

void makePolygons(const BeamGrid& grid, const LabelImage& labels, const std::vector<PlanarRegion>& regions,
                  const PolygonOptions& options, PolygonMemory& memory, std::vector<PlanarPolygon>& polygons, int threads) {
  const std::vector<PixelPiece>& pieces = memory.pieces.pieces;
  std::vector<KeptList<PlanarPolygon>>& of_region = memory.of_region;
  of_region.resize(std::max(of_region.size(), regions.size()));
  forEachPart(threads, static_cast<int>(regions.size()), memory.of_thread, [&](int k, OutlineMemory& scratch) {
    const PlanarRegion& region = regions[k];
    const auto before = [](const PixelPiece& piece, std::int32_t id) { return piece.outer().label < id; };
    auto piece = std::lower_bound(pieces.begin(), pieces.end(), region.id, before);
    RegionOutliner outliner(grid, labels, region, options, scratch);
    for (bool first = true; piece != pieces.end() && piece->outer().label == region.id; ++piece, first = false) {
      if (first || piece->outer().pixels >= options.min_hole_size) outliner.add(memory.contours.corners, *piece, 0);
    }
    of_region[k].clear();
    outliner.liftTo(region.id, of_region[k]);
  });
  std::size_t count = 0;
  for (std::size_t k = 0; k < regions.size(); ++k) count += of_region[k].size();
  polygons.resize(count);
  auto next = polygons.begin();
  for (std::size_t k = 0; k < regions.size(); ++k) next = std::copy(of_region[k].begin(), of_region[k].end(), next);
  if (options.snap_creases) {
    snapCreases(grid, labels, regions, std::max(0.0, options.simplification_tolerance),
                std::max(0.0, options.pixel_tolerance), polygons);
  }
}

}  // namespace ppc
