// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Geometry>
#include <vector>

namespace ppc {

/// @brief Axes on a plane: u x v = normal, so that a ring that is counter-clockwise seen from the sensor is so in (u, v).
struct PlaneAxes {
  explicit PlaneAxes(const Eigen::Vector3d& normal) : u(normal.unitOrthogonal()), v(normal.cross(u)) {}
  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const { return {u.dot(p), v.dot(p)}; }
  Eigen::Vector3d u, v;
};

/// @brief The region with this id, or null. Precondition: ascending ids.
const PlanarRegion* regionById(const std::vector<PlanarRegion>& regions, std::int32_t id);

}  // namespace ppc
