// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <string>
#include <vector>

namespace ppc {

/// @brief Planes and polygons of a file of polygonsJson(); other members of Segmentation stay empty. Rings are taken as they
/// are, be they valid or not; numbers are not.
/// @throws std::runtime_error naming the file, the plane and the number that no such file has: ids and counts that are not
/// whole, normals that are not of length 1, lengths beyond 1e9 m, two planes of one id.
Segmentation readPolygons(const std::string& path);

/// @brief Planes of a file {"planes": [{"id", "normal", "d"}]}, ascending ids; other members stay empty.
/// @throws std::runtime_error as readPolygons().
std::vector<PlanarRegion> readPlanes(const std::string& path);

}  // namespace ppc
