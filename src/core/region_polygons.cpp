// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_polygons.h"

#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/polygon_piece.h"
#include "patch_plane_clustering/core/ring_crossings.h"
#include "piece_split.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace ppc {
namespace {

// A piece that is still not simple after so many cuts has beams without order and is dropped.
constexpr int kMaxCuts = 12;

// Smallest area of a polygon [m^2].
constexpr double kMinArea = 1e-8;

class RegionOutliner {
 public:
  RegionOutliner(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region, const PolygonOptions& options)
      : projection_(grid, labels, region), options_(options) {
    tolerance_.metres = std::max(0.0, options.simplification_tolerance);
    if (tolerance_.metres > 0.0) tolerance_.pixels = std::max(0.0, options.pixel_tolerance);
  }

  /// Adds the piece bounded by these rings, outer first; in several parts where one will not do.
  void add(const std::vector<PixelCorner>& corners, const std::vector<PixelRing>& rings, int cuts) {
    std::vector<std::vector<OutlinePoint>> outlines;
    for (const PixelRing& ring : rings) {
      std::vector<OutlinePoint> outline = project(corners, ring);
      if (outline.size() >= 3) {
        outlines.push_back(std::move(outline));
      } else if (!ring.hole) {
        return;
      }
    }
    if (std::optional<PolygonPiece> piece = makePiece(outlines, tolerance_)) {
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
  // Corners on the plane; those that coincide (at the pole all lines meet) count once.
  std::vector<OutlinePoint> project(const std::vector<PixelCorner>& corners, const PixelRing& ring) {
    std::vector<OutlinePoint> outline;
    outline.reserve(ring.end - ring.begin);
    const auto apart = [](const OutlinePoint& a, const OutlinePoint& b) {
      return (a.point - b.point).squaredNorm() > 4.0 * kRingClearance * kRingClearance;
    };
    for (std::size_t i = ring.begin; i < ring.end; ++i) {
      const OutlinePoint p = projection_.project(corners[i]);
      if (outline.empty() || apart(outline.back(), p)) outline.push_back(p);
    }
    while (outline.size() > 1 && !apart(outline.back(), outline.front())) outline.pop_back();
    return outline;
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

  CornerProjection projection_;
  const PolygonOptions& options_;
  OutlineTolerance tolerance_;
  std::vector<PolygonPiece> pieces_;
};

}  // namespace

std::vector<PlanarPolygon> extractPolygons(const BeamGrid& grid, const LabelImage& labels,
                                           const std::vector<PlanarRegion>& regions, const PolygonOptions& options) {
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
  std::vector<PlanarPolygon> polygons;
  auto piece = pieces.begin();
  for (const PlanarRegion& region : regions) {
    while (piece != pieces.end() && piece->front().label < region.id) ++piece;
    RegionOutliner outliner(grid, labels, region, options);
    for (bool first = true; piece != pieces.end() && piece->front().label == region.id; ++piece, first = false) {
      if (first || piece->front().pixels >= options.min_hole_size) outliner.add(contours.corners, *piece, 0);
    }
    outliner.moveTo(region.id, polygons);
  }
  return polygons;
}

}  // namespace ppc
