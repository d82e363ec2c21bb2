// SPDX-License-Identifier: BSD-3-Clause
// Range images and clouds of analytic scenes, as messages.
#pragma once

#include "../core/polygon_test_tools.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <sensor_msgs/PointCloud2.h>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace ppc::testing_tools {

/// A plate 2 m ahead, 1.6 m wide and 1.2 m high, with a window of 0.5 m x 0.4 m; nothing behind it.
constexpr double kPlateArea = 1.6 * 1.2 - 0.5 * 0.4;

inline Face plate(double distance = 2.0) {
  Plane plane;
  plane.normal = -Eigen::Vector3d::UnitX();
  plane.d = -distance;
  return {plane, [](const Eigen::Vector3d& p) {
            const bool window = std::abs(p.y()) < 0.25 && std::abs(p.z()) < 0.2;
            return std::abs(p.y()) < 0.8 && std::abs(p.z()) < 0.6 && !window;
          }};
}

inline std_msgs::Header headerAt(double stamp, const std::string& frame = "tilt_base") {
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  header.frame_id = frame;
  return header;
}

/// A nodding scan of the faces, 0.5 deg by 0.5 deg; +Inf where there is none.
inline RangeImageMsg scanMessage(const std::vector<Face>& faces, double stamp) {
  RangeImage image = noddingScan(91, 121, -22.5 * kDegree, 22.5 * kDegree, 30.0 * kDegree);
  BeamGrid grid = toBeamGrid(image);
  scanFaces(faces, grid);
  for (std::size_t i = 0; i < image.ranges.size(); ++i) {
    image.ranges[i] = grid.valid(static_cast<int>(i)) ? grid.range[i] : std::numeric_limits<float>::infinity();
  }
  return toMessage(image, headerAt(stamp));
}

/// What an RGB-D camera would see of a wall 2 m ahead and a box's face 1 m ahead: optical frame, z forward, fields in
/// another order and with padding; a margin of columns is NaN.
inline sensor_msgs::PointCloud2 cameraCloud(double stamp) {
  constexpr int kRows = 96, kCols = 128, kMargin = 4;
  sensor_msgs::PointCloud2 cloud;
  cloud.header = headerAt(stamp, "camera_optical");
  cloud.height = kRows;
  cloud.width = kCols;
  cloud.point_step = 32;
  cloud.row_step = kCols * cloud.point_step + 16;  // rows may be padded as well
  const auto add = [&](const char* name, std::uint32_t offset) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  };
  add("rgb", 16);
  add("z", 4);
  add("y", 9);  // not aligned
  add("x", 24);
  cloud.data.assign(cloud.row_step * kRows, 0xAB);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      const double u = (c - 63.5) / 120.0, v = (r - 47.5) / 120.0;
      double z = 2.0;
      if (std::abs(u) < 0.2 && std::abs(v) < 0.2) z = 1.0;
      if (c < kMargin) z = std::numeric_limits<double>::quiet_NaN();
      const float x = static_cast<float>(u * z), y = static_cast<float>(v * z), depth = static_cast<float>(z);
      std::uint8_t* point = &cloud.data[r * cloud.row_step + c * cloud.point_step];
      std::memcpy(point + 4, &depth, 4);
      std::memcpy(point + 9, &y, 4);
      std::memcpy(point + 24, &x, 4);
    }
  }
  return cloud;
}

}  // namespace ppc::testing_tools
