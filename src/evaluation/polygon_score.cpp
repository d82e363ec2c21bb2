// SPDX-License-Identifier: BSD-3-Clause
#define BOOST_GEOMETRY_NO_ROBUSTNESS  // coordinates are of the order of 1: no need to rescale them to integers
#include "patch_plane_clustering/evaluation/polygon_score.h"

#include "polygon_plane.h"

#include <algorithm>
#include <boost/geometry/algorithms/is_valid.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/strategies/strategies.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace ppc {
namespace {

// Even-odd test against all rings of a polygon at once, edges sorted into horizontal strips.
class InsideTest {
 public:
  InsideTest(const PlanarPolygon& polygon, const PlaneAxes& axes) {
    addRing(polygon.outer, axes);
    for (const auto& hole : polygon.holes) addRing(hole, axes);
    strips_.resize(kStrips);
    for (const auto& edge : edges_) {
      const auto [low, high] = std::minmax(edge.first.y(), edge.second.y());
      for (int s = strip(low); s <= strip(high); ++s) strips_[s].push_back(edge);
    }
  }

  bool operator()(const Eigen::Vector2d& p) const {
    if (!box_.contains(p)) return false;
    bool inside = false;
    for (const auto& [a, b] : strips_[strip(p.y())]) {
      if ((a.y() > p.y()) == (b.y() > p.y())) continue;
      if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
    }
    return inside;
  }

 private:
  using Edge = std::pair<Eigen::Vector2d, Eigen::Vector2d>;
  static constexpr int kStrips = 128;

  void addRing(const std::vector<Eigen::Vector3d>& ring, const PlaneAxes& axes) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      edges_.emplace_back(axes(ring[i]), axes(ring[(i + 1) % ring.size()]));
      box_.extend(edges_.back().first);
    }
  }
  int strip(double y) const {
    const double height = box_.max().y() - box_.min().y();
    const double at = height > 0.0 ? (y - box_.min().y()) / height * kStrips : 0.0;
    return std::clamp(static_cast<int>(at), 0, kStrips - 1);
  }

  Eigen::AlignedBox2d box_;
  std::vector<Edge> edges_;
  std::vector<std::vector<Edge>> strips_;
};

using Point2 = boost::geometry::model::d2::point_xy<double>;
using Polygon2 = boost::geometry::model::polygon<Point2, false, false>;  // counter-clockwise, open

std::string faultOf(const PlanarPolygon& polygon, const PlanarRegion* region) {
  if (region == nullptr) return "has no plane";
  const PlaneAxes axes(region->plane.normal);
  Polygon2 flat;
  bool finite = true;
  const auto copy = [&](const std::vector<Eigen::Vector3d>& from, Polygon2::ring_type& to) {
    for (const auto& p : from) {
      finite = finite && p.allFinite();
      const Eigen::Vector2d q = axes(p);
      to.emplace_back(q.x(), q.y());
    }
  };
  copy(polygon.outer, flat.outer());
  flat.inners().resize(polygon.holes.size());
  for (std::size_t i = 0; i < polygon.holes.size(); ++i) copy(polygon.holes[i], flat.inners()[i]);
  if (!finite) return "has a vertex that is not finite";
  std::string reason;
  return boost::geometry::is_valid(flat, reason) ? "" : reason;
}

}  // namespace

const PlanarRegion* regionById(const std::vector<PlanarRegion>& regions, std::int32_t id) {
  const auto at = std::lower_bound(regions.begin(), regions.end(), id,
                                   [](const PlanarRegion& region, std::int32_t value) { return region.id < value; });
  return at != regions.end() && at->id == id ? &*at : nullptr;
}

LabelImage renderPolygons(const BeamGrid& beams, const std::vector<PlanarRegion>& regions,
                          const std::vector<PlanarPolygon>& polygons) {
  LabelImage image{beams.rows, beams.cols, std::vector<std::int32_t>(static_cast<std::size_t>(beams.size()), 0)};
  std::vector<double> nearest(image.labels.size(), std::numeric_limits<double>::infinity());
  for (const PlanarPolygon& polygon : polygons) {
    const PlanarRegion* region = regionById(regions, polygon.id);
    if (region == nullptr) continue;
    const PlaneAxes axes(region->plane.normal);
    const InsideTest inside(polygon, axes);
    for (int i = 0; i < beams.size(); ++i) {
      const Eigen::Vector3d origin = beams.origin(i).cast<double>();
      const Eigen::Vector3d direction = beams.direction(i).cast<double>();
      const double range = region->plane.rangeAlong(origin, direction);
      if (!(range > 0.0 && range < nearest[i])) continue;
      if (!inside(axes(origin + range * direction))) continue;
      nearest[i] = range;
      image.labels[i] = polygon.id;
    }
  }
  return image;
}

LabelImage withoutUnmeasured(const BeamGrid& grid, LabelImage labels) {
  if (labels.rows != grid.rows || labels.cols != grid.cols) {
    throw std::invalid_argument("labels of " + std::to_string(labels.rows) + " x " + std::to_string(labels.cols) +
                                " pixels for an image of " + std::to_string(grid.rows) + " x " + std::to_string(grid.cols));
  }
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.valid(i)) labels.labels[i] = 0;
  }
  return labels;
}

PolygonQuality polygonQuality(const std::vector<PlanarRegion>& regions, const std::vector<PlanarPolygon>& polygons) {
  PolygonQuality quality;
  for (const PlanarPolygon& polygon : polygons) {
    ++quality.polygons;
    quality.holes += static_cast<int>(polygon.holes.size());
    const PlanarRegion* region = regionById(regions, polygon.id);
    const auto count = [&](const std::vector<Eigen::Vector3d>& ring) {
      quality.vertices += static_cast<int>(ring.size());
      for (const auto& p : ring) {
        if (region == nullptr) continue;
        quality.largest_off_plane = std::max(quality.largest_off_plane, std::abs(region->plane.signedDistance(p)));
      }
    };
    count(polygon.outer);
    for (const auto& hole : polygon.holes) count(hole);
    const std::string fault = faultOf(polygon, region);
    if (fault.empty()) continue;
    if (quality.invalid++ == 0) quality.first_fault = "polygon " + std::to_string(polygon.id) + ": " + fault;
  }
  return quality;
}

double compression(int points, const PolygonQuality& quality) {
  const double rings = quality.polygons + quality.holes;
  const double bytes = 12.0 * quality.vertices + 32.0 * quality.polygons + 4.0 * rings;
  return quality.polygons > 0 ? 12.0 * points / bytes : 0.0;
}

}  // namespace ppc
