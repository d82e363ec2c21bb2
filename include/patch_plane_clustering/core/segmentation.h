// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/plane.h"

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ppc {

/// @brief One label a pixel, row-major: 0 = no plane, otherwise the id of a region.
struct LabelImage {
  int rows = 0;
  int cols = 0;
  std::vector<std::int32_t> labels;
};

/// @brief One planar region of a label image.
struct PlanarRegion {
  std::int32_t id = 0;                                   ///< its value in the label image, 1..N
  Plane plane;                                           ///< of the region's points, see describeRegions()
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();    ///< mean of the points [m]
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (nx, ny, nz, d); rank 3, since |n| = 1
  int points = 0;                                        ///< number of pixels with this label
  double rms = 0.0;                                      ///< root mean square distance of the points from the plane [m]
};

/// @brief A piece of a plane, bounded by simple rings. Rings are not repeated at the end; the outer one runs
/// counter-clockwise and the holes clockwise as seen from the sensor; all vertices lie on the plane. A region that no single
/// ring can bound has several polygons of the same id.
struct PlanarPolygon {
  std::int32_t id = 0;                              ///< id of the region
  std::vector<Eigen::Vector3d> outer;               ///< [m]
  std::vector<std::vector<Eigen::Vector3d>> holes;  ///< [m]
  double area = 0.0;                                ///< of the outer ring less the holes [m^2]
};

/// @brief Time of one named stage of a segmentation [ms].
using StageTime = std::pair<std::string, double>;

/// @brief Result of segmenting one range image.
struct Segmentation {
  LabelImage labels;
  std::vector<PlanarRegion> regions;    ///< in ascending id; ids run from 1 in descending number of points
  std::vector<PlanarPolygon> polygons;  ///< in ascending id
  std::vector<StageTime> stages;        ///< in the order of execution
  int valid_points = 0;                 ///< pixels with a measurement
  int regions_without_polygon = 0;      ///< regions whose outline collapsed (smaller than the tolerance)
};

}  // namespace ppc
