// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/simulated_scanner_parameters.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace patch_plane_clustering {
namespace {

// Reads a parameter if it is set; complains if its type is wrong.
template <typename T>
void read(const ros::NodeHandle& nh, const std::string& name, T& value) {
  if (nh.hasParam(name) && !nh.getParam(name, value)) {
    throw std::invalid_argument("parameter " + nh.resolveName(name) + " has the wrong type");
  }
}

template <typename T>
void read(const ros::NodeHandle& nh, const std::string& name, T& value, T low, T high) {
  read(nh, name, value);
  if (!(value >= low && value <= high)) {
    throw std::invalid_argument("parameter " + nh.resolveName(name) + " is " + std::to_string(value) +
                                ", allowed: " + std::to_string(low) + " to " + std::to_string(high));
  }
}

Eigen::Vector3d readVector(const ros::NodeHandle& nh, const std::string& name) {
  std::vector<double> v{0.0, 0.0, 0.0};
  read(nh, name, v);
  if (v.size() != 3 || !std::isfinite(v[0] + v[1] + v[2])) {
    throw std::invalid_argument("parameter " + nh.resolveName(name) + " has " + std::to_string(v.size()) +
                                " values, allowed: 3 finite ones");
  }
  return {v[0], v[1], v[2]};
}

std::string readName(const ros::NodeHandle& nh, const std::string& name, std::string value) {
  read(nh, name, value);
  if (value.empty()) throw std::invalid_argument("parameter " + nh.resolveName(name) + " is empty");
  return value;
}

sim::ErrorModel readErrors(const ros::NodeHandle& nh) {
  double noise_scale = 1.0;
  bool exact = false, realistic = false;
  read(nh, "noise_scale", noise_scale, 0.0, 1000.0);
  read(nh, "exact", exact);
  read(nh, "realistic", realistic);
  if (exact) return sim::ErrorModel::none();
  return realistic ? sim::ErrorModel::realistic(noise_scale) : sim::ErrorModel::dataSheet(noise_scale);
}

}  // namespace

SimulatedScannerParameters readSimulatedScannerParameters(const ros::NodeHandle& nh) {
  SimulatedScannerParameters p;
  p.scene = readName(nh, "scene", p.scene);
  int seed = 1;
  read(nh, "seed", seed, 0, std::numeric_limits<int>::max());
  p.seed = static_cast<std::uint64_t>(seed);

  p.scanner.sensor = sim::makeSensor(readName(nh, "sensor", "utm_30lx"));
  sim::Motion& motion = p.scanner.motion;
  motion.kind = sim::motionFromName(readName(nh, "motion", "nodding"));
  motion.axis = sim::axisFromName(readName(nh, "axis", "pitch"));
  read(nh, "amplitude", motion.amplitude, 0.0, M_PI);
  read(nh, "pass_angle", motion.pass_angle, 0.01, 2.0 * M_PI + 1e-6);
  read(nh, "lines_per_pass", motion.lines_per_pass, 2, 100000);
  const Eigen::Vector3d rpy = readVector(nh, "mount_rpy");
  p.scanner.mount = sim::mountFrom(readVector(nh, "lever_arm"), rpy);
  read(nh, "joint_rate", p.scanner.joint_rate, 1.0, 10000.0);
  p.scanner.errors = readErrors(nh);

  p.names.base_frame = readName(nh, "base_frame", p.names.base_frame);
  p.names.laser_frame = readName(nh, "laser_frame", p.names.laser_frame);
  p.names.joint = readName(nh, "joint_name", p.names.joint);
  read(nh, "real_time_factor", p.real_time_factor, 0.001, 1000.0);
  read(nh, "replay_passes", p.replay_passes, 0, 1000);
  read(nh, "publish_clock", p.publish_clock);
  read(nh, "publish_tf", p.publish_tf);
  read(nh, "joint_drop_rate", p.joint_drop_rate, 0.0, 1.0);
  read(nh, "scan_drop_rate", p.scan_drop_rate, 0.0, 1.0);
  read(nh, "joint_delay", p.joint_delay, 0.0, 10.0);
  return p;
}

}  // namespace patch_plane_clustering
