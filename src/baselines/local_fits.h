// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/plane.h"

#include <Eigen/Core>
#include <vector>

namespace ppc {

/// @brief Sums of points that give their least-squares plane; points can be added one by one.
struct PointSums {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  int n = 0;

  void add(const Eigen::Vector3d& p) {
    sum += p;
    outer.noalias() += p * p.transpose();
    ++n;
  }
};

struct LocalPlane {
  Plane plane;
  double mean_square = 0.0;  ///< mean square distance of the points [m^2]
  double curvature = 0.0;    ///< smallest eigenvalue of the scatter over their sum, 0..1/3
};

/// @brief Plane of the sums, normal towards the origin. Precondition: at least 3 points.
LocalPlane fitPlane(const PointSums& sums);

/// @brief Half the sides of a window that is as wide as high in angle.
struct Window {
  int rows = 1;
  int cols = 1;
};

/// @brief Noise as PPC sees it (estimated or from the sensor model), and the window with the given half side in columns.
NoiseModel noiseOf(const BeamGrid& grid, const Config& config);
Window windowOf(const BeamGrid& grid, int half_cols);

/// @brief Points of the window about pixel i whose range is within `gap` of its own.
PointSums windowSums(const BeamGrid& grid, int i, const Window& window, float gap);

/// @brief Farthest that neighbours of a surface are apart in range [m].
inline float gapAt(double range, double sigma) { return static_cast<float>(0.03 * range + 6.0 * sigma); }

/// @brief Local plane of every pixel; n < 3 points: curvature 1 and a normal against the beam.
std::vector<LocalPlane> localPlanes(const BeamGrid& grid, const NoiseModel& noise, const Window& window);

}  // namespace ppc
