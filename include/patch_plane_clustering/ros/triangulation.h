// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>
#include <vector>

namespace ppc {

/// @brief Cuts a polygon with holes into triangles, by the tessellator of the OpenGL utility library (no display needed).
/// @param normal unit normal of the polygon's plane; the triangles run counter-clockwise about it.
/// @return three vertices a triangle [m]; empty if the polygon has no area. Thread-safe.
std::vector<Eigen::Vector3d> triangulate(const PlanarPolygon& polygon, const Eigen::Vector3d& normal);

}  // namespace ppc
