// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include "patch_plane_clustering/core/beam_grid.h"

#include <sensor_msgs/image_encodings.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace ppc {
namespace {

constexpr std::uint32_t kMostPixels = 100000000;  // keeps a corrupt size from eating the memory
constexpr double kFarthestPose = 1e6;             // [m]

double finiteLimit(float range_max) {
  return std::isinf(range_max) && range_max > 0.0F ? std::numeric_limits<float>::max() : range_max;
}

sensor_msgs::PointField field(const char* name, std::uint32_t offset) {
  sensor_msgs::PointField f;
  f.name = name;
  f.offset = offset;
  f.datatype = sensor_msgs::PointField::FLOAT32;
  f.count = 1;
  return f;
}

geometry_msgs::Pose toPose(const Eigen::Isometry3d& pose) {
  geometry_msgs::Pose message;
  const Eigen::Quaterniond q(pose.linear());
  message.position.x = pose.translation().x();
  message.position.y = pose.translation().y();
  message.position.z = pose.translation().z();
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
  return message;
}

Eigen::Isometry3d fromPose(const geometry_msgs::Pose& message) {
  const Eigen::Quaterniond q(message.orientation.w, message.orientation.x, message.orientation.y, message.orientation.z);
  if (!(std::abs(q.norm() - 1.0) < 0.01)) throw std::invalid_argument("range image: a line pose has no unit quaternion");
  Eigen::Isometry3d pose(q.normalized());
  pose.translation() = Eigen::Vector3d(message.position.x, message.position.y, message.position.z);
  return pose;
}

}  // namespace

ros::Time toTime(double stamp) {
  if (!(stamp >= 0.0 && stamp < 4294967295.0)) return ros::Time();
  return ros::Time(stamp);
}

RangeImageMsg toMessage(const RangeImage& image, const std_msgs::Header& header) {
  RangeImageMsg message;
  message.header = header;
  message.height = static_cast<std::uint32_t>(image.rows);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.bearing_min = static_cast<float>(image.bearing_min);
  message.bearing_increment = static_cast<float>(image.bearing_increment);
  message.range_min = static_cast<float>(image.range_min);
  message.range_max = static_cast<float>(image.range_max);
  message.ranges = image.ranges;
  message.intensities = image.intensities;
  message.tilts.assign(image.tilts.begin(), image.tilts.end());
  message.row_stamps.reserve(image.row_stamps.size());
  for (const double stamp : image.row_stamps) message.row_stamps.push_back(toTime(stamp));
  message.poses_per_row = static_cast<std::uint32_t>(image.poses_per_row);
  message.line_poses.reserve(image.line_poses.size());
  for (const Eigen::Isometry3d& pose : image.line_poses) message.line_poses.push_back(toPose(pose));
  return message;
}

RangeImageMsg toMessage(const Sweep& sweep, const std_msgs::Header& header) {
  RangeImageMsg message = toMessage(sweep.image, header);
  message.lines = toMessage(sweep.accounts);
  return message;
}

LineAccountsMsg toMessage(const LineAccounts& accounts) {
  LineAccountsMsg message;
  message.lines_in = accounts.lines_in;
  message.lines_in_images = accounts.lines_in_images;
  message.lines_pending = accounts.pending;
  for (std::size_t i = 0; i < kDropCauses; ++i) {
    const auto cause = static_cast<DropCause>(i);
    if (accounts.drops(cause) == 0) continue;
    message.dropped.emplace_back();
    message.dropped.back().cause = dropCauseName(cause);
    message.dropped.back().lines = accounts.drops(cause);
  }
  return message;
}

void fromMessage(const RangeImageMsg& message, RangeImage& image) {
  if (message.height > kMostPixels || message.width > kMostPixels || message.poses_per_row > kMostPixels) {
    throw std::invalid_argument("range image: height " + std::to_string(message.height) + ", width " +
                                std::to_string(message.width) + " or poses_per_row " +
                                std::to_string(message.poses_per_row) + " is too large");
  }
  image.rows = static_cast<int>(message.height);
  image.cols = static_cast<int>(message.width);
  image.bearing_min = message.bearing_min;
  image.bearing_increment = message.bearing_increment;
  image.range_min = message.range_min;
  image.range_max = finiteLimit(message.range_max);
  image.ranges = message.ranges;
  image.intensities = message.intensities;
  image.poses_per_row = static_cast<int>(message.poses_per_row);
  image.tilts.assign(message.tilts.begin(), message.tilts.end());
  image.row_stamps.clear();
  image.row_stamps.reserve(message.row_stamps.size());
  for (const ros::Time& stamp : message.row_stamps) image.row_stamps.push_back(stamp.toSec());
  image.line_poses.clear();
  image.line_poses.reserve(message.line_poses.size());
  for (const geometry_msgs::Pose& pose : message.line_poses) image.line_poses.push_back(fromPose(pose));
  checkConsistent(image);
  for (const Eigen::Isometry3d& pose : image.line_poses) {
    if (pose.translation().norm() > kFarthestPose) {
      throw std::invalid_argument("range image: a line pose is more than 1000 km from the origin of its frame");
    }
  }
}

RangeImage fromMessage(const RangeImageMsg& message) {
  RangeImage image;
  fromMessage(message, image);
  return image;
}

sensor_msgs::PointCloud2 toPointCloud(const RangeImage& image, const std_msgs::Header& header) {
  const BeamGrid grid = toBeamGrid(image);
  const bool intense = !image.intensities.empty();
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  cloud.height = static_cast<std::uint32_t>(image.rows);
  cloud.width = static_cast<std::uint32_t>(image.cols);
  cloud.fields = {field("x", 0), field("y", 4), field("z", 8)};
  if (intense) cloud.fields.push_back(field("intensity", 12));
  cloud.point_step = intense ? 16 : 12;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = false;
  cloud.data.resize(static_cast<std::size_t>(cloud.row_step) * cloud.height);
  std::uint8_t* out = cloud.data.data();
  for (int i = 0; i < grid.size(); ++i, out += cloud.point_step) {
    const Eigen::Vector3f p = grid.point(i);
    std::memcpy(out, p.data(), 12);
    if (intense) std::memcpy(out + 12, &image.intensities[static_cast<std::size_t>(i)], 4);
  }
  return cloud;
}

sensor_msgs::Image toRadialImage(const RangeImage& image, const std_msgs::Header& header) {
  sensor_msgs::Image message;
  message.header = header;
  message.height = static_cast<std::uint32_t>(image.rows);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.encoding = sensor_msgs::image_encodings::TYPE_32FC1;
  message.step = message.width * 4;
  message.data.resize(image.ranges.size() * 4);
  std::memcpy(message.data.data(), image.ranges.data(), message.data.size());
  return message;
}

ScanLine toScanLine(const sensor_msgs::LaserScan& scan, double time_offset) {
  ScanLine line;
  line.stamp = scan.header.stamp.isZero() ? 0.0 : scan.header.stamp.toSec() + time_offset;
  line.time_increment = scan.time_increment;
  line.bearing_min = scan.angle_min;
  line.bearing_increment = scan.angle_increment;
  line.range_min = scan.range_min;
  line.range_max = finiteLimit(scan.range_max);
  line.ranges = scan.ranges;
  line.intensities = scan.intensities;
  return line;
}

std::string faultOf(const sensor_msgs::LaserScan& scan) {
  if (scan.ranges.empty() || !std::isfinite(scan.angle_increment) || scan.angle_increment == 0.0F) return {};
  // Drivers differ in whether angle_max is the last beam's bearing or one step further.
  const double steps = (static_cast<double>(scan.angle_max) - scan.angle_min) / scan.angle_increment;
  const double expected = static_cast<double>(scan.ranges.size()) - 1.0;
  if (std::abs(steps - expected) <= 1.5 + 1e-3 * expected) return {};
  return "angle_min, angle_max and angle_increment make " + std::to_string(steps + 1.0) + " beams, but there are " +
         std::to_string(scan.ranges.size());
}

std::string frameName(const std::string& frame_id) {
  return !frame_id.empty() && frame_id[0] == '/' ? frame_id.substr(1) : frame_id;
}

std::string faultOf(const sensor_msgs::LaserScan& scan, const std::string& laser_frame) {
  const std::string frame = frameName(scan.header.frame_id);
  if (frame.empty()) return "frame_id is empty";
  if (!laser_frame.empty() && frame != laser_frame) return "frame_id '" + frame + "' is not '" + laser_frame + "'";
  return faultOf(scan);
}

}  // namespace ppc
