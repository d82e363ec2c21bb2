// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_polygons.h"

#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/crease_snapping.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/polygon_piece.h"
#include "patch_plane_clustering/core/ring_loops.h"
#include "patch_plane_clustering/core/ring_simplification.h"
#include "piece_split.h"

#include <algorithm>
#include <boost/geometry/algorithms/convex_hull.hpp>
#include <boost/geometry/geometries/multi_point.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/ring.hpp>
#include <boost/geometry/strategies/strategies.hpp>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace ppc {
namespace {

// A piece that is still not simple after so many cuts has beams without order and is dropped.
constexpr int kMaxCuts = 12;

// A piece is seen edge-on if the beams through more than this share of its outline meet the plane nowhere near the points.
constexpr double kEdgeOn = 1.0 / 3.0;

// A loop of an outline may be cut off if it encloses no more than this share of the outline's area.
constexpr double kLoopShare = 2e-3;

// Smallest area of a polygon [m^2].
constexpr double kMinArea = 1e-8;

class RegionOutliner {
 public:
  RegionOutliner(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region, const PolygonOptions& options)
      : grid_(grid), labels_(labels), id_(region.id), projection_(grid, labels, region), options_(options) {
    tolerance_.metres = std::max(0.0, options.simplification_tolerance);
    if (tolerance_.metres > 0.0) tolerance_.pixels = std::max(0.0, options.pixel_tolerance);
  }

  /// Adds the piece bounded by these rings, outer first; in several parts where one will not do.
  void add(const std::vector<PixelCorner>& corners, const std::vector<PixelRing>& rings, int cuts) {
    std::vector<std::vector<OutlinePoint>> outlines;
    std::size_t limited = 0;
    for (const PixelRing& ring : rings) {
      const std::size_t before = projection_.limited();
      std::vector<OutlinePoint> outline = project(corners, ring);
      if (outlines.empty()) limited = projection_.limited() - before;
      if (outline.size() >= 3) {
        outlines.push_back(std::move(outline));
      } else if (!ring.hole) {
        return;
      }
    }
    std::optional<PolygonPiece> piece = makePiece(outlines, tolerance_);
    if (!piece) piece = makePieceWithoutLoops(outlines);
    if (!piece && static_cast<double>(limited) > kEdgeOn * static_cast<double>(rings.front().end - rings.front().begin)) {
      piece = makePiece({hullOf(maskOfPiece(corners, rings))}, tolerance_);
    }
    if (piece) {
      keep(std::move(*piece));
    } else if (cuts < kMaxCuts) {
      cut(corners, rings, cuts + 1);
    }
  }

  void moveTo(std::int32_t id, std::vector<PlanarPolygon>& polygons) {
    std::stable_sort(pieces_.begin(), pieces_.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
    for (const PolygonPiece& piece : pieces_) {
      PlanarPolygon polygon{id, lift(piece.outer), {}, piece.area};
      for (const auto& hole : piece.holes) polygon.holes.push_back(lift(hole));
      polygons.push_back(std::move(polygon));
    }
  }

 private:
  // Corners on the plane; those that coincide count once.
  std::vector<OutlinePoint> project(const std::vector<PixelCorner>& corners, const PixelRing& ring) {
    std::vector<OutlinePoint> outline(ring.end - ring.begin);
    projection_.project(corners.data() + ring.begin, outline.size(), outline.data());
    dropRepeats(outline);
    return outline;
  }

  // Beams along a plane do not tell where on it an outline runs; the points do, about.
  std::vector<OutlinePoint> hullOf(const PieceMask& mask) const {
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
    std::vector<OutlinePoint> outline(hull.size());
    for (std::size_t i = 0; i < hull.size(); ++i) outline[i].point = {hull[i].x(), hull[i].y()};
    dropRepeats(outline);
    return outline;
  }

  std::optional<PolygonPiece> makePieceWithoutLoops(std::vector<std::vector<OutlinePoint>>& outlines) const {
    const double area = std::abs(signedArea(outlines.front().data(), outlines.front().size()));
    bool shorter = false;
    for (auto& outline : outlines) shorter |= cutLoops(outline, kLoopShare * area);
    if (!shorter) return std::nullopt;
    return makePiece(outlines, tolerance_);
  }

  void cut(const std::vector<PixelCorner>& corners, const std::vector<PixelRing>& rings, int cuts) {
    PieceMask mask = maskOfPiece(corners, rings);
    if (cuts == 1 ? !splitAtFolds(projection_, mask) && !splitInHalf(mask) : !splitInHalf(mask)) return;
    PixelContours parts = traceContours(mask.labels);
    for (PixelCorner& corner : parts.corners) {
      corner.row += mask.row;
      corner.col += mask.col;
    }
    for (const std::vector<PixelRing>& part : ringsByComponent(parts, options_.min_hole_size)) {
      if (part.front().pixels >= std::min(options_.min_hole_size, rings.front().pixels / 4)) add(parts.corners, part, cuts);
    }
  }

  void keep(PolygonPiece piece) {
    if (piece.area > kMinArea) pieces_.push_back(std::move(piece));
  }

  std::vector<Eigen::Vector3d> lift(const std::vector<Eigen::Vector2d>& ring) const {
    std::vector<Eigen::Vector3d> lifted;
    lifted.reserve(ring.size());
    for (const auto& p : ring) lifted.push_back(projection_.lift(p));
    return lifted;
  }

  const BeamGrid& grid_;
  const LabelImage& labels_;
  std::int32_t id_;
  CornerProjection projection_;
  const PolygonOptions& options_;
  OutlineTolerance tolerance_;
  std::vector<PolygonPiece> pieces_;
};

}  // namespace

std::vector<PlanarPolygon> extractPolygons(const BeamGrid& grid, const LabelImage& labels,
                                           const std::vector<PlanarRegion>& regions, const PolygonOptions& options,
                                           int threads) {
  if (labels.rows != grid.rows || labels.cols != grid.cols || labels.labels.size() != grid.range.size()) {
    throw std::invalid_argument("label image of " + std::to_string(labels.rows) + " x " + std::to_string(labels.cols) +
                                " pixels does not fit the grid of " + std::to_string(grid.rows) + " x " +
                                std::to_string(grid.cols));
  }
  const PixelContours contours = traceContours(labels);
  std::vector<std::vector<PixelRing>> pieces = ringsByComponent(contours, options.min_hole_size);
  // By label, then by size: the largest part of a region is kept however small it is.
  std::stable_sort(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) {
    return a.front().label != b.front().label ? a.front().label < b.front().label : a.front().pixels > b.front().pixels;
  });
  std::vector<std::vector<PlanarPolygon>> of_region(regions.size());
  forEachPart(threads, static_cast<int>(regions.size()), [&](int k) {
    const PlanarRegion& region = regions[k];
    const auto before = [](const std::vector<PixelRing>& piece, std::int32_t id) { return piece.front().label < id; };
    auto piece = std::lower_bound(pieces.begin(), pieces.end(), region.id, before);
    RegionOutliner outliner(grid, labels, region, options);
    for (bool first = true; piece != pieces.end() && piece->front().label == region.id; ++piece, first = false) {
      if (first || piece->front().pixels >= options.min_hole_size) outliner.add(contours.corners, *piece, 0);
    }
    outliner.moveTo(region.id, of_region[k]);
  });
  std::vector<PlanarPolygon> polygons;
  for (auto& found : of_region) std::move(found.begin(), found.end(), std::back_inserter(polygons));
  if (options.snap_creases) {
    snapCreases(grid, labels, regions, std::max(0.0, options.simplification_tolerance),
                std::max(0.0, options.pixel_tolerance), polygons);
  }
  return polygons;
}

}  // namespace ppc
