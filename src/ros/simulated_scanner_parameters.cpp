// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/simulated_scanner_parameters.h"

#include <cmath>
#include <limits>

namespace ppc {
namespace {

Eigen::Vector3d readVector(ParameterReader& reader, const std::string& name) {
  const std::vector<double> v = reader.getVector(name, {0.0, 0.0, 0.0});
  return {v[0], v[1], v[2]};
}

// A preset, of which every error source can be changed by its own name.
sim::ErrorModel readErrors(ParameterReader& reader) {
  const bool exact = reader.getBool("exact", false), realistic = reader.getBool("realistic", false);
  sim::ErrorModel errors = exact       ? sim::ErrorModel::none()
                           : realistic ? sim::ErrorModel::realistic(1.0)
                                       : sim::ErrorModel::dataSheet(1.0);
  for (const sim::ErrorField& field : sim::errorFields()) {
    const double value = reader.getDouble(field.name, errors.*field.value, 0.0, field.max);
    // Launch files always give the noise scale; `exact` is the stronger word.
    if (!exact || field.value != &sim::ErrorModel::noise_scale) errors.*field.value = value;
  }
  errors.correlated_noise = reader.getBool("correlated_noise", errors.correlated_noise);
  errors.motion_in_line = reader.getBool("motion_in_line", errors.motion_in_line);
  return errors;
}

}  // namespace

SimulatedScannerParameters readSimulatedScannerParameters(ParameterReader& reader) {
  SimulatedScannerParameters p;
  p.scene = reader.getChoice("scene", p.scene, sim::sceneNames());
  p.seed = static_cast<std::uint64_t>(reader.getInt("seed", 1, 0, std::numeric_limits<int>::max()));

  p.scanner.sensor = sim::makeSensor(reader.getChoice("sensor", "utm_30lx", sim::sensorNames()));
  sim::Motion& motion = p.scanner.motion;
  motion.kind = sim::motionFromName(reader.getChoice("motion", "nodding", {"nodding", "spinning"}));
  motion.axis = sim::axisFromName(reader.getChoice("axis", "pitch", {"roll", "pitch", "yaw"}));
  motion.amplitude = reader.getDouble("amplitude", motion.amplitude, 0.0, M_PI);
  // The whole turn as text has as many digits as its writer liked.
  motion.pass_angle = reader.getDouble("pass_angle", motion.pass_angle, 0.01, 2.0 * M_PI + 1e-3);
  motion.lines_per_pass = reader.getInt("lines_per_pass", motion.lines_per_pass, 2, 100000);
  const Eigen::Vector3d lever_arm = readVector(reader, "lever_arm");
  p.scanner.mount = sim::mountFrom(lever_arm, readVector(reader, "mount_rpy"));
  p.scanner.joint_rate = reader.getDouble("joint_rate", p.scanner.joint_rate, 1.0, 10000.0);
  p.scanner.errors = readErrors(reader);

  p.names.base_frame = reader.getFrame("base_frame", p.names.base_frame);
  p.names.laser_frame = reader.getFrame("laser_frame", p.names.laser_frame);
  p.names.joint = reader.getString("joint_name", p.names.joint);
  p.real_time_factor = reader.getDouble("real_time_factor", p.real_time_factor, 0.001, 1000.0);
  p.replay_passes = reader.getInt("replay_passes", p.replay_passes, 0, 1000);
  p.publish_clock = reader.getBool("publish_clock", p.publish_clock);
  p.publish_tf = reader.getBool("publish_tf", p.publish_tf);
  p.joint_drop_rate = reader.getDouble("joint_drop_rate", p.joint_drop_rate, 0.0, 1.0);
  p.scan_drop_rate = reader.getDouble("scan_drop_rate", p.scan_drop_rate, 0.0, 1.0);
  p.joint_delay = reader.getDouble("joint_delay", p.joint_delay, 0.0, 10.0);
  return p;
}

}  // namespace ppc
