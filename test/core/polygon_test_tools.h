// SPDX-License-Identifier: BSD-3-Clause
// Analytic scans and polygon checks shared by the tests of the outlines.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // a false alarm of GCC 12 in Boost.Geometry
#endif

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/range_image.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Geometry>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace ppc::testing_tools {

namespace bg = boost::geometry;
using BoostPolygon = bg::model::polygon<bg::model::d2::point_xy<double>, false, false>;  // counter-clockwise, open

constexpr double kDegree = M_PI / 180.0;

/// A nodding scan: x forward, y left, z up; tilt is a rotation about y, positive down. All ranges NaN.
inline RangeImage noddingScan(int rows, int cols, double tilt_min, double tilt_max, double bearing_max,
                              const Eigen::Vector3d& lever_arm = Eigen::Vector3d::Zero()) {
  RangeImage image;
  image.rows = rows;
  image.cols = cols;
  image.bearing_min = -bearing_max;
  image.bearing_increment = cols > 1 ? 2.0 * bearing_max / (cols - 1) : 0.0;
  image.range_min = 0.01;
  image.range_max = 100.0;
  image.ranges.assign(static_cast<std::size_t>(rows) * cols, std::numeric_limits<float>::quiet_NaN());
  for (int r = 0; r < rows; ++r) {
    const double tilt = rows > 1 ? tilt_min + r * (tilt_max - tilt_min) / (rows - 1) : tilt_min;
    Eigen::Isometry3d pose(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()));
    pose.translation() = pose.linear() * lever_arm;
    image.line_poses.push_back(pose);
    image.tilts.push_back(tilt);
  }
  return image;
}

/// A face of a scene: a plane, and which of its points belong to it.
struct Face {
  Plane plane;
  std::function<bool(const Eigen::Vector3d&)> contains;
};

/// Measures the nearest face along every beam, without noise. @return labels 1.. in the order of the faces.
inline LabelImage scanFaces(const std::vector<Face>& faces, BeamGrid& grid) {
  LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
  for (int i = 0; i < grid.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    const Eigen::Vector3d origin = grid.origin(i).cast<double>(), direction = grid.direction(i).cast<double>();
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const double t = faces[f].plane.rangeAlong(origin, direction);
      if (!(t > 0.01) || !(t < nearest) || !faces[f].contains(origin + t * direction)) continue;
      nearest = t;
      labels.labels[i] = static_cast<std::int32_t>(f) + 1;
    }
    if (labels.labels[i] > 0) grid.range[i] = static_cast<float>(nearest);
  }
  return labels;
}

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
