// SPDX-License-Identifier: BSD-3-Clause
// Polygon checks shared by the tests of the outlines.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // a false alarm of GCC 12 in Boost.Geometry
#endif

#include "analytic_scenes.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cmath>
#include <string>
#include <vector>

namespace ppc::testing_tools {

namespace bg = boost::geometry;
using BoostPolygon = bg::model::polygon<bg::model::d2::point_xy<double>, false, false>;  // counter-clockwise, open

/// The polygon in coordinates of its plane, seen from the side the normal points to.
inline BoostPolygon flatten(const PlanarPolygon& polygon, const Plane& plane) {
  const Eigen::Vector3d x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  BoostPolygon flat;
  const auto add = [&](const std::vector<Eigen::Vector3d>& ring, auto& out) {
    for (const auto& p : ring) out.emplace_back(x.dot(p), y.dot(p));
  };
  add(polygon.outer, flat.outer());
  flat.inners().resize(polygon.holes.size());
  for (std::size_t h = 0; h < polygon.holes.size(); ++h) add(polygon.holes[h], flat.inners()[h]);
  return flat;
}

/// Empty if the polygon keeps every promise of extractPolygons(); otherwise what is wrong.
inline std::string faultOf(const PlanarPolygon& polygon, const Plane& plane) {
  const auto ringFault = [&](const std::vector<Eigen::Vector3d>& ring) -> std::string {
    if (ring.size() < 3) return "ring of " + std::to_string(ring.size()) + " vertices";
    for (const auto& p : ring) {
      if (!p.allFinite()) return "vertex not finite";
      if (std::abs(plane.signedDistance(p)) > 1e-6) return "vertex off the plane";
    }
    return "";
  };
  std::string fault = ringFault(polygon.outer);
  for (const auto& hole : polygon.holes) fault += ringFault(hole);
  if (!fault.empty()) return fault;
  const BoostPolygon flat = flatten(polygon, plane);
  if (!bg::is_valid(flat, fault)) return fault;  // simple, holes inside and apart, outer counter-clockwise, holes clockwise
  const double area = bg::area(flat);
  if (!(std::abs(area - polygon.area) <= 1e-6 * (1.0 + area))) return "area says " + std::to_string(polygon.area);
  return "";
}

inline double totalArea(const std::vector<PlanarPolygon>& polygons, std::int32_t id) {
  double area = 0.0;
  for (const auto& polygon : polygons) area += polygon.id == id ? polygon.area : 0.0;
  return area;
}

}  // namespace ppc::testing_tools
