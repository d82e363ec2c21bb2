// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/driver_options.h"

#include "patch_plane_clustering/core/tilt_pose_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ppc {

DriverOptions readDriverOptions(ParameterReader& reader) {
  DriverOptions o;
  o.joint_name = reader.getString("joint_name", o.joint_name);
  o.base_frame = reader.getFrame("base_frame", o.base_frame);
  o.laser_frame = reader.getFrame("laser_frame", o.laser_frame);
  o.fixed_frame = reader.getFrame("fixed_frame", o.fixed_frame);
  o.axis = tiltAxis(reader.getChoice("axis", "pitch", {"roll", "pitch", "yaw", "-roll", "-pitch", "-yaw"}));

  const std::string motion = reader.getChoice("motion", "nodding", {"nodding", "spinning"});
  const std::string turn = reader.getChoice("turn", "half", {"half", "full"});
  o.sweep.motion = motion == "nodding" ? SweepMotion::kNodding
                   : turn == "half"    ? SweepMotion::kHalfTurn
                                       : SweepMotion::kFullTurn;
  o.sweep.turn_hysteresis = reader.getDouble("turn_hysteresis", o.sweep.turn_hysteresis, 1e-4, 1.0);
  o.sweep.poses_per_row = reader.getInt("poses_per_row", o.sweep.poses_per_row, 1, 1000);
  o.sweep.max_lines = reader.getInt("max_lines", o.sweep.max_lines, 2, 100000);
  // More than that, and every sweep would be too small.
  o.sweep.min_lines = reader.getInt("min_lines", std::min(o.sweep.min_lines, o.sweep.max_lines), 1, o.sweep.max_lines);
  o.sweep.min_tilt_span = reader.getDouble("min_tilt_span", o.sweep.min_tilt_span, 0.0, 6.3);
  o.sweep.max_line_gap = reader.getDouble("max_line_gap", o.sweep.max_line_gap, 0.01, 3600.0);
  o.sweep.standing_lines = reader.getInt("standing_lines", o.sweep.standing_lines, 2, 100000);
  o.sweep.skip = reader.getInt("skip", o.sweep.skip, 0, 1000);
  o.sweep.max_wait = reader.getDouble("max_wait", o.sweep.max_wait, 0.1, 3600.0);
  o.sweep.max_queue = reader.getInt("max_queue", o.sweep.max_queue, 1, 100000);

  o.foresee = reader.getBool("foresee", o.foresee);

  o.track.max_gap = reader.getDouble("max_joint_gap", o.track.max_gap, 0.001, 60.0);
  o.track.max_speed = reader.getDouble("max_joint_speed", o.track.max_speed, 0.01, 1000.0);
  o.mount_timeout = reader.getDouble("mount_timeout", o.mount_timeout, 0.0, 3600.0);
  o.idle_timeout = reader.getDouble("idle_timeout", o.idle_timeout, 0.1, 3600.0);
  o.sweep_timeout = reader.getDouble("sweep_timeout", o.sweep_timeout, 1.0, 86400.0);
  o.time_offset = reader.getDouble("time_offset", o.time_offset, -10.0, 10.0);

  constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> arm = reader.getVector("lever_arm", {kUnset, kUnset, kUnset});
  std::vector<double> rpy = reader.getVector("mount_rpy", {kUnset, kUnset, kUnset});
  if (!std::isnan(arm[0]) || !std::isnan(rpy[0])) {
    if (std::isnan(arm[0])) arm.assign(3, 0.0);
    if (std::isnan(rpy[0])) rpy.assign(3, 0.0);
    o.mount = Eigen::Translation3d(arm[0], arm[1], arm[2]) * Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX());
  }
  return o;
}

}  // namespace ppc
