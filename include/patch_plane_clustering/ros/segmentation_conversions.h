// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/ros/messages.h"

#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>
#include <vector>

namespace ppc {

/// @brief Beams of an organised cloud, sensor at the frame's origin. Fields x, y and z may be float32 or float64, in any
/// order, with any padding; what is not finite is no measurement.
/// @throws std::invalid_argument naming what is wrong: unorganised (a side of 1), fields missing or of another type, sizes
/// that do not fit the data, foreign byte order.
BeamGrid gridFromCloud(const sensor_msgs::PointCloud2& cloud);

/// @brief Coordinates of the points of a cloud.
struct CloudCoordinates {
  std::vector<float> x, y, z;
};

/// @brief The same into a grid that is there, whose memory is used again. @param coordinates overwritten, likewise.
void gridFromCloud(const sensor_msgs::PointCloud2& cloud, CloudCoordinates& coordinates, BeamGrid& grid);

/// @brief Polygons as a message. Every polygon finds its region by id. @throws std::invalid_argument if it does not.
PlanarPolygonArray toPolygonArray(const Segmentation& segmentation, const std_msgs::Header& header);

/// @brief Label image, encoding 32SC1, 0 = none.
sensor_msgs::Image toLabelImage(const LabelImage& labels, const std_msgs::Header& header);

/// @brief Organised cloud with fields x, y, z (NaN where there is no measurement), rgb (regionColor) and label (uint32).
sensor_msgs::PointCloud2 toSegmentedCloud(const BeamGrid& grid, const LabelImage& labels, const std_msgs::Header& header);

/// @brief Counts and stage times. The method's name, the total time and the nodelet's counters are left to the caller.
SegmentationStatistics toStatistics(const Segmentation& segmentation, const std_msgs::Header& header);

}  // namespace ppc
