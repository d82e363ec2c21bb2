// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/ros/messages.h"
#include "wait_for.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace ppc {

/// Distance from `origin`, inside the test's room, along `direction` to its walls. The room is a box about the world's
/// origin.
inline Eigen::Vector3d roomSize() { return {4.0, 3.0, 1.5}; }
inline double rangeInRoom(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double nearest = 1e9;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(direction[k]) < 1e-12) continue;
    nearest = std::min(nearest, ((direction[k] > 0.0 ? 1.0 : -1.0) * roomSize()[k] - origin[k]) / direction[k]);
  }
  return nearest;
}

/// How far a point is from the nearest wall of the room.
inline double offTheWalls(const Eigen::Vector3d& p) { return (p.cwiseAbs() - roomSize()).cwiseAbs().minCoeff(); }

/// Plays a laser on a motor to one driver, faster than real time, and collects what comes out.
class ScanPlayer {
 public:
  explicit ScanPlayer(const std::string& ns) : ns_(ns), nh_(ns) {
    scan_pub_ = nh_.advertise<sensor_msgs::LaserScan>("scan", 1000);
    joint_pub_ = nh_.advertise<sensor_msgs::JointState>("joint_states", 1000);
    tf_pub_ = nh_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
    image_sub_ = nh_.subscribe<RangeImageMsg>("range_image", 50, [this](const auto& m) { images.push_back(m); });
    points_sub_ = nh_.subscribe<sensor_msgs::PointCloud2>("points", 50, [this](const auto& m) { clouds.push_back(m); });
    radial_sub_ =
        nh_.subscribe<sensor_msgs::Image>("range_image/image", 50, [this](const auto& m) { radials.push_back(m); });
    diagnostics_sub_ = nh_.subscribe<diagnostic_msgs::DiagnosticArray>("/diagnostics", 50, [this](const auto& array) {
      for (const auto& status : array->status) {
        if (status.name == ns_.substr(1) + "/driver: tilt scan driver") diagnostics = status;
      }
    });
  }

  ScanPlayer(const ScanPlayer&) = delete;  // its functions refer to it
  ScanPlayer& operator=(const ScanPlayer&) = delete;

  bool connect() {
    return waitFor([this] {
      return scan_pub_.getNumSubscribers() > 0 && (!with_joint || joint_pub_.getNumSubscribers() > 0) &&
             (!with_tf || tf_pub_.getNumSubscribers() > 0) && image_sub_.getNumPublishers() > 0 &&
             points_sub_.getNumPublishers() > 0 && radial_sub_.getNumPublishers() > 0;
    });
  }

  Eigen::Isometry3d laserAt(double t) const {
    return basePose(t) * Eigen::Isometry3d(Eigen::AngleAxisd(tilt(t), axis)) * mount;
  }

  sensor_msgs::LaserScan scan(double t) const {
    sensor_msgs::LaserScan s;
    s.header.frame_id = ns_.substr(1) + "_laser";
    s.header.stamp = ros::Time(t);
    s.angle_min = -1.5F;
    s.angle_increment = 0.025F;
    s.angle_max = s.angle_min + static_cast<float>(beams - 1) * s.angle_increment;
    s.time_increment = time_increment;
    s.scan_time = 0.025F;
    s.range_min = 0.02F;
    s.range_max = 30.0F;
    for (int i = 0; i < beams; ++i) {
      const Eigen::Isometry3d laser = laserAt(s.header.stamp.toSec() + i * static_cast<double>(s.time_increment));
      const double bearing = static_cast<double>(s.angle_min) + i * static_cast<double>(s.angle_increment);
      const Eigen::Vector3d in_laser(std::cos(bearing), std::sin(bearing), 0.0);
      s.ranges.push_back(static_cast<float>(rangeInRoom(laser.translation(), laser.linear() * in_laser)));
      s.intensities.push_back(static_cast<float>(i));
    }
    return s;
  }

  void publishJoint(const sensor_msgs::JointState& message) { joint_pub_.publish(message); }

  sensor_msgs::JointState jointSample(double t) const {
    sensor_msgs::JointState m;
    m.header.stamp = ros::Time(t);
    m.name = {"other_joint", "tilt_joint"};
    m.position = {7.0, std::remainder(tilt(m.header.stamp.toSec()), 2.0 * M_PI)};
    return m;
  }

  void publishTransform(double t, const std::string& parent, const std::string& child, const Eigen::Isometry3d& pose) {
    tf2_msgs::TFMessage m;
    m.transforms.resize(1);
    m.transforms[0].header.stamp = ros::Time(t);
    m.transforms[0].header.frame_id = parent;
    m.transforms[0].child_frame_id = child;
    const Eigen::Quaterniond q(pose.linear());
    auto& out = m.transforms[0].transform;
    out.translation.x = pose.translation().x();
    out.translation.y = pose.translation().y();
    out.translation.z = pose.translation().z();
    out.rotation.x = q.x();
    out.rotation.y = q.y();
    out.rotation.z = q.z();
    out.rotation.w = q.w();
    tf_pub_.publish(m);
  }

  void publishScan(const sensor_msgs::LaserScan& s) {
    ++scans_sent;
    scan_pub_.publish(s);
  }

  /// Lines at 40 Hz, joint samples and transforms at 100 Hz, from `from` to `to` [s].
  void play(double from, double to) {
    const auto first = static_cast<long>(std::lround(from * 200.0));
    const auto last = static_cast<long>(std::lround(to * 200.0));
    for (long tick = first; tick < last; ++tick) {
      const double t = static_cast<double>(tick) / 200.0;
      if (tick % 2 == 0) {
        if (with_joint && !silent(t)) send_joint(jointSample(t));
        const std::string name = ns_.substr(1);
        const Eigen::Isometry3d in_base = basePose(t).inverse() * laserAt(t);
        if (with_tf && !silent(t)) publishTransform(t, name + "_base", name + "_laser", in_base);
        if (with_base_motion) publishTransform(t, "odom", name + "_base", basePose(t));
      }
      if (tick % 5 == 0) send_scan(scan(t));
      ros::spinOnce();
      ros::WallDuration(0.001).sleep();
    }
  }

  /// Value of a diagnostic key as a number; -1 if there is none.
  double diagnosed(const std::string& key) const {
    for (const auto& value : diagnostics.values) {
      if (value.key == key) return std::stod(value.value);
    }
    return -1.0;
  }

  /// Waits for a report that was made after this call.
  bool freshDiagnostics() {
    diagnostics = {};
    return waitFor([this] { return !diagnostics.values.empty() || diagnostics.level != 0; });
  }

  double linesDropped() const {
    double sum = 0.0;
    for (const auto& value : diagnostics.values) {
      if (value.key.rfind("Lines dropped: ", 0) == 0) sum += std::stod(value.value);
    }
    return sum;
  }

  std::function<double(double)> tilt = [](double t) { return -0.7 * std::cos(2.0 * M_PI * t / 4.0); };
  std::function<bool(double)> silent = [](double) { return false; };  // joint and tf of the laser
  // What becomes of each message; a test may delay, repeat, spoil or drop it.
  std::function<void(const sensor_msgs::LaserScan&)> send_scan = [this](const auto& s) { publishScan(s); };
  std::function<void(const sensor_msgs::JointState&)> send_joint = [this](const auto& j) { publishJoint(j); };
  std::function<Eigen::Isometry3d(double)> basePose = [](double) { return Eigen::Isometry3d::Identity(); };  // in the room
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  float time_increment = 1.25e-4F;
  int beams = 121;
  int scans_sent = 0;
  bool with_joint = true;
  bool with_tf = false;
  bool with_base_motion = false;

  std::vector<RangeImageMsg::ConstPtr> images;
  std::vector<sensor_msgs::PointCloud2::ConstPtr> clouds;
  std::vector<sensor_msgs::Image::ConstPtr> radials;
  diagnostic_msgs::DiagnosticStatus diagnostics;

 private:
  std::string ns_;
  ros::NodeHandle nh_;
  ros::Publisher scan_pub_, joint_pub_, tf_pub_;
  ros::Subscriber image_sub_, points_sub_, radial_sub_, diagnostics_sub_;
};

}  // namespace ppc
