// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "local_fits.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace ppc {

/// @brief The grid as PCL's organised cloud; no measurement = NaN.
inline pcl::PointCloud<pcl::PointXYZ>::Ptr toPclCloud(const BeamGrid& grid) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(
      new pcl::PointCloud<pcl::PointXYZ>(static_cast<std::uint32_t>(grid.cols), static_cast<std::uint32_t>(grid.rows)));
  cloud->is_dense = false;
  for (int i = 0; i < grid.size(); ++i) {
    cloud->points[i].getVector3fMap() =
        grid.valid(i) ? grid.point(i) : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  }
  return cloud;
}

/// @brief Normals of the windows of the grid, as PCL's; NaN where there is no measurement.
inline pcl::PointCloud<pcl::Normal>::Ptr toPclNormals(const BeamGrid& grid, const std::vector<LocalPlane>& planes) {
  pcl::PointCloud<pcl::Normal>::Ptr normals(
      new pcl::PointCloud<pcl::Normal>(static_cast<std::uint32_t>(grid.cols), static_cast<std::uint32_t>(grid.rows)));
  normals->is_dense = false;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < grid.size(); ++i) {
    pcl::Normal& normal = normals->points[i];
    normal.getNormalVector3fMap() = planes[i].plane.normal.cast<float>();
    normal.curvature = static_cast<float>(planes[i].curvature);
    if (!grid.valid(i)) normal = pcl::Normal(kNaN, kNaN, kNaN);
  }
  return normals;
}

/// @brief Valid pixels of the grid, ascending.
inline std::vector<int> validPixels(const BeamGrid& grid) {
  std::vector<int> pixels;
  for (int i = 0; i < grid.size(); ++i) {
    if (grid.valid(i)) pixels.push_back(i);
  }
  return pixels;
}

/// @brief An image without labels.
inline LabelImage noLabels(const BeamGrid& grid) {
  return {grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
}

}  // namespace ppc
