// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/range_image.h"

#include <vector>

namespace ppc::bench {

/// Side of a patch of the floor [pixels].
constexpr int kFloorPatch = 8;

/// @brief What any patch-based method has to do at the very least: the yardstick for everything else.
///
/// Ranges of a scan that nods about y with the laser on the axis become sums over 8 x 8 patches, and a plane a patch. No
/// noise model, no gates, no neighbours, no labels; the motion within a line is ignored. Plain vector code, four lanes,
/// which is what x86-64 and arm64 have without further flags.
struct FloorGeometry {
  std::vector<float> cos_tilt, minus_sin_tilt;  ///< rows: x and z of a beam of bearing 0
  std::vector<float> cos_bearing, sin_bearing;  ///< cols
  float range_min = 0.0F, range_max = 0.0F;     ///< [m]
};

/// @brief Cosines and sines once a row and once a column.
FloorGeometry floorGeometry(const RangeImage& image);

/// @brief Moments of all patches, one array a sum, row by row. Coordinates are relative to a point of the patch, so that
/// single precision is enough.
struct FloorSums {
  int rows = 0, cols = 0;                           ///< of patches; the last ones of a row or column may be incomplete
  std::vector<float> n;                             ///< valid points
  std::vector<float> origin_x, origin_y, origin_z;  ///< [m]
  std::vector<float> x, y, z, xx, xy, xz, yy, yz, zz;
};

/// @brief One pass from ranges to moments. @param sums is resized as needed: no allocation once it has the size.
void sumPatches(const std::vector<float>& ranges, const FloorGeometry& geometry, FloorSums& sums);

/// @brief Least-squares planes normal . p = d, normal towards the sensor; zero where a patch has fewer than 3 points.
struct FloorPlanes {
  std::vector<float> normal_x, normal_y, normal_z, d;
  std::vector<float> variance;  ///< mean square distance of the points from the plane [m^2]
};

/// @brief Smallest eigenvector of each patch's scatter matrix, four patches at once. There must be at least four.
void fitPatches(const FloorSums& sums, FloorPlanes& planes);

}  // namespace ppc::bench
