// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/simulated_messages.h"

namespace ppc {

sensor_msgs::LaserScan toLaserScan(const sim::Scanner& scanner, const sim::ScanLine& line, const ros::Time& start,
                                   const SimulatedNames& names) {
  const sim::Sensor& sensor = scanner.options().sensor;
  sensor_msgs::LaserScan scan;
  scan.header.seq = static_cast<std::uint32_t>(line.index);
  scan.header.stamp = start + ros::Duration(line.stamp);
  scan.header.frame_id = names.laser_frame;
  scan.angle_min = static_cast<float>(sensor.bearing_min);
  scan.angle_increment = static_cast<float>(sensor.bearing_increment);
  scan.angle_max = static_cast<float>(sensor.bearing_min + (sensor.beams - 1) * sensor.bearing_increment);
  scan.time_increment = static_cast<float>(scanner.timeIncrement());
  scan.scan_time = static_cast<float>(scanner.lineDuration());
  scan.range_min = static_cast<float>(sensor.range_min);
  scan.range_max = static_cast<float>(sensor.range_max);
  scan.ranges = line.ranges;
  return scan;
}

sensor_msgs::JointState toJointState(const sim::JointSample& sample, const ros::Time& start, const SimulatedNames& names) {
  sensor_msgs::JointState state;
  state.header.stamp = start + ros::Duration(sample.stamp);
  state.name.push_back(names.joint);
  state.position.push_back(sample.angle);
  return state;
}

tf2_msgs::TFMessage toTransforms(const sim::Scanner& scanner, const sim::JointSample& sample, const ros::Time& start,
                                 const SimulatedNames& names) {
  const Eigen::Isometry3d pose = scanner.nominalPose(sample.angle);
  const Eigen::Quaterniond q(pose.linear());
  geometry_msgs::TransformStamped t;
  t.header.stamp = start + ros::Duration(sample.stamp);
  t.header.frame_id = names.base_frame;
  t.child_frame_id = names.laser_frame;
  t.transform.translation.x = pose.translation().x();
  t.transform.translation.y = pose.translation().y();
  t.transform.translation.z = pose.translation().z();
  t.transform.rotation.w = q.w();
  t.transform.rotation.x = q.x();
  t.transform.rotation.y = q.y();
  t.transform.rotation.z = q.z();
  tf2_msgs::TFMessage message;
  message.transforms.push_back(t);
  return message;
}

}  // namespace ppc
