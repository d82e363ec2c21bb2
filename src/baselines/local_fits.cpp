// SPDX-License-Identifier: BSD-3-Clause
#include "local_fits.h"

#include "patch_plane_clustering/core/patch_grid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ppc {

LocalPlane fitPlane(const PointSums& sums) {
  const double n = sums.n;
  const Eigen::Vector3d mean = sums.sum / n;
  const Eigen::Matrix3d scatter = sums.outer / n - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(scatter);
  LocalPlane local;
  local.plane.normal = eigen.eigenvectors().col(0);
  if (local.plane.normal.dot(mean) > 0.0) local.plane.normal = -local.plane.normal;
  local.plane.d = local.plane.normal.dot(mean);
  local.mean_square = std::max(0.0, eigen.eigenvalues()[0]);
  local.curvature = local.mean_square / std::max(1e-12, scatter.trace());
  return local;
}

NoiseModel noiseOf(const BeamGrid& grid, const Config& config) {
  if (config.noise_scale > 0.0) return {config.sensor, config.noise_scale};
  return NoiseModel::estimate(makePatchGrid(grid, std::min(config.patch_size, std::max(grid.rows, grid.cols)), true),
                              config.sensor);
}

Window windowOf(const BeamGrid& grid, int half_cols) {
  if (grid.rows < 2 || grid.cols < 2) return {half_cols, half_cols};
  const int r = grid.rows / 2, c = grid.cols / 2;
  const Eigen::Vector3f middle = grid.direction(grid.index(r, c));
  const float across = (middle - grid.direction(grid.index(r, c - 1))).norm();
  const float along = (middle - grid.direction(grid.index(r - 1, c))).norm();
  const float ratio = along > 0.0F ? across / along : 1.0F;
  return {static_cast<int>(std::lround(std::clamp(ratio, 0.25F, 8.0F) * static_cast<float>(half_cols))), half_cols};
}

PointSums windowSums(const BeamGrid& grid, int i, const Window& window, float gap) {
  PointSums sums;
  if (!grid.valid(i)) return sums;
  const int row = i / grid.cols, col = i % grid.cols;
  for (int r = std::max(0, row - window.rows); r <= std::min(grid.rows - 1, row + window.rows); ++r) {
    for (int c = std::max(0, col - window.cols); c <= std::min(grid.cols - 1, col + window.cols); ++c) {
      const int j = grid.index(r, c);
      if (grid.valid(j) && std::abs(grid.range[j] - grid.range[i]) < gap) sums.add(grid.point(j).cast<double>());
    }
  }
  return sums;
}

std::vector<LocalPlane> localPlanes(const BeamGrid& grid, const NoiseModel& noise, const Window& window) {
  std::vector<LocalPlane> planes(static_cast<std::size_t>(grid.size()));
  for (int i = 0; i < grid.size(); ++i) {
    const double range = grid.range[i];
    PointSums sums;
    if (grid.valid(i)) sums = windowSums(grid, i, window, gapAt(range, noise.sigma(range)));
    if (sums.n >= 3) {
      planes[i] = fitPlane(sums);
    } else {
      planes[i].plane.normal = -grid.direction(i).cast<double>();
      planes[i].curvature = 1.0;
    }
  }
  return planes;
}

}  // namespace ppc
