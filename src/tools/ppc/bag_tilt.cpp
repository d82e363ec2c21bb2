// SPDX-License-Identifier: BSD-3-Clause
#include "bag_tilt.h"

#include "bag_message.h"
#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/joint_sample.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace ppc {
namespace {

struct StampedPose {
  double stamp;
  Eigen::Isometry3d pose;
};

// A link of the tf tree over time.
struct Link {
  std::string parent;
  std::vector<StampedPose> poses;

  bool turns() const {
    return std::any_of(poses.begin(), poses.end(), [&](const StampedPose& other) {
      return Eigen::AngleAxisd(poses.front().pose.linear().transpose() * other.pose.linear()).angle() > 1e-3;
    });
  }
};

std::string listed(const std::set<std::string>& names) {
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

std::string chooseTopic(const rosbag::Bag& bag, const std::string& type, const std::string& wanted,
                        const std::string& option) {
  std::set<std::string> topics;
  rosbag::View view(bag);
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    if (connection->topic == wanted && connection->datatype != type) {
      throw std::runtime_error("topic " + wanted + " is of type " + connection->datatype + ", not " + type);
    }
    if (connection->datatype == type) topics.insert(connection->topic);
  }
  if (!wanted.empty()) {
    if (topics.count(wanted) != 0) return wanted;
    throw std::runtime_error("has no topic " + wanted + " (" + type + " topics: " + listed(topics) + ")");
  }
  if (topics.size() > 1)
    throw std::runtime_error("has several " + type + " topics, choose with " + option + ": " + listed(topics));
  return topics.empty() ? "" : *topics.begin();
}

// The joint of that name, or else the only one or the one that moves most.
std::string chooseJoint(const rosbag::Bag& bag, const std::string& topic, const std::string& wanted) {
  std::map<std::string, std::pair<double, double>> ranges;
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto joints = messageOf<sensor_msgs::JointState>(message);
    if (!joints) continue;
    for (std::size_t i = 0; i < std::min(joints->name.size(), joints->position.size()); ++i) {
      const double angle = joints->position[i];
      if (!std::isfinite(angle)) continue;
      auto& range = ranges.try_emplace(joints->name[i], angle, angle).first->second;
      range = {std::min(range.first, angle), std::max(range.second, angle)};
    }
  }
  if (!wanted.empty()) {
    if (ranges.count(wanted) != 0) return wanted;
    std::set<std::string> names;
    for (const auto& each : ranges) names.insert(each.first);
    throw std::runtime_error("has no joint '" + wanted + "' on " + topic + " (joints: " + listed(names) + ")");
  }
  if (ranges.empty()) throw std::runtime_error("has no joint with a position on " + topic);
  return std::max_element(ranges.begin(), ranges.end(),
                          [](const auto& a, const auto& b) {
                            return a.second.second - a.second.first < b.second.second - b.second.first;
                          })
      ->first;
}

std::map<std::string, Link> readLinks(const rosbag::Bag& bag) {
  std::map<std::string, Link> links;
  rosbag::View view(bag, rosbag::TypeQuery("tf2_msgs/TFMessage"));
  for (const rosbag::MessageInstance& message : view) {
    const auto transforms = messageOf<tf2_msgs::TFMessage>(message);
    if (!transforms) continue;
    for (const auto& transform : transforms->transforms) {
      const auto& t = transform.transform.translation;
      const auto& q = transform.transform.rotation;
      const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
      if (!std::isfinite(t.x + t.y + t.z) || !(std::abs(rotation.norm() - 1.0) < 0.01)) continue;
      Link& link = links[frameName(transform.child_frame_id)];
      link.parent = frameName(transform.header.frame_id);
      link.poses.push_back({transform.header.stamp.toSec(), Eigen::Translation3d(t.x, t.y, t.z) * rotation.normalized()});
    }
  }
  return links;
}

double turnAbout(const Eigen::Vector3d& axis, const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return 2.0 * std::atan2(q.vec().dot(axis), q.w());
}

TiltTrack jointTrack(const rosbag::Bag& bag, const std::string& topic, const std::string& joint) {
  TiltTrackOptions options;
  options.capacity = 10000000;
  TiltTrack track(options);
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto joints = messageOf<sensor_msgs::JointState>(message);
    if (!joints) continue;
    const JointSample sample = readJointSample(*joints, joint);
    if (sample.present && sample.fault.empty()) track.add(sample.stamp, sample.angle);
  }
  return track;
}

// Walks from the laser towards the root of the tf tree up to the link that turns, and takes the tilt out of that link.
void findMount(const rosbag::Bag& bag, const Eigen::Vector3d& axis, BagTilt& tilt) {
  const auto links = readLinks(bag);
  Eigen::Isometry3d below = Eigen::Isometry3d::Identity();  // laser in the child frame of the link
  std::string frame = tilt.laser_frame;
  for (std::size_t depth = 0; depth <= links.size(); ++depth) {
    const auto found = links.find(frame);
    if (found == links.end()) break;
    const Link& link = found->second;
    if (!link.turns()) {
      below = link.poses.front().pose * below;
      frame = link.parent;
      continue;
    }
    tilt.base_frame = link.parent;
    const auto mountAt = [&](const StampedPose& at, double angle) {
      tilt.mount = Eigen::AngleAxisd(-angle, axis) * at.pose * below;
    };
    if (tilt.joint_states.empty()) {
      for (const auto& at : link.poses) tilt.tilts.emplace_back(at.stamp, turnAbout(axis, at.pose.linear()));
      mountAt(link.poses.front(), tilt.tilts.front().second);
      return;
    }
    const TiltTrack track = jointTrack(bag, tilt.joint_states, tilt.joint);
    for (const auto& at : link.poses) {
      double angle = 0.0;
      if (track.lookup(at.stamp, angle) != TiltTrack::Status::kReady) continue;
      mountAt(at, angle);
      return;
    }
    break;
  }
  if (tilt.joint_states.empty()) {
    throw std::runtime_error("has neither joint states nor a transform on /tf that turns frame '" + tilt.laser_frame + "'");
  }
  tilt.note = "no transform on /tf tells how '" + tilt.laser_frame + "' sits on the motor: laser taken to be on the axis";
}

}  // namespace

BagTilt findTilt(const rosbag::Bag& bag, const BagOptions& options) {
  BagTilt tilt;
  tilt.scan = chooseTopic(bag, "sensor_msgs/LaserScan", options.scan, "--scan");
  if (tilt.scan.empty()) throw std::runtime_error("has no sensor_msgs/LaserScan topic");
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(tilt.scan))) {
    const auto scan = messageOf<sensor_msgs::LaserScan>(message);
    if (!scan || !faultOf(*scan, "").empty()) continue;
    tilt.laser_frame = frameName(scan->header.frame_id);
    break;
  }
  if (!options.tilt_from_tf) {
    tilt.joint_states = chooseTopic(bag, "sensor_msgs/JointState", options.joint_states, "--joint-states");
    if (!tilt.joint_states.empty()) tilt.joint = chooseJoint(bag, tilt.joint_states, options.joint);
  }
  const Eigen::Vector3d axis = tiltAxis(options.axis);
  const bool mount_given = !options.lever_arm.empty() || !options.mount_rpy.empty();
  if (!mount_given || tilt.joint_states.empty()) findMount(bag, axis, tilt);
  if (mount_given) {
    const auto value = [](const std::vector<double>& v, std::size_t i) { return v.empty() ? 0.0 : v[i]; };
    tilt.mount =
        Eigen::Translation3d(value(options.lever_arm, 0), value(options.lever_arm, 1), value(options.lever_arm, 2)) *
        Eigen::AngleAxisd(value(options.mount_rpy, 2), Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(value(options.mount_rpy, 1), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(value(options.mount_rpy, 0), Eigen::Vector3d::UnitX());
  }
  if (!options.base_frame.empty()) tilt.base_frame = options.base_frame;
  if (tilt.base_frame.empty()) tilt.base_frame = "tilt_base";
  return tilt;
}

}  // namespace ppc
