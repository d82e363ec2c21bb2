// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

namespace ppc::sim {

/// @brief How the motor moves the laser.
struct Motion {
  enum class Kind { kNodding, kSpinning };
  Kind kind = Kind::kNodding;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit; +y: positive tilt is nose-down (REP 103)
  double centre = 0.0;                              ///< nodding: tilt half-way [rad]
  double amplitude = 60.0 * 0.017453292519943295;   ///< nodding: from the centre to a turning point [rad]
  double pass_angle = 3.141592653589793;            ///< spinning: angle of one pass [rad]
  int lines_per_pass = 300;                         ///< lines from one turning point to the next, or in pass_angle
  double turn_share = 0.1;  ///< nodding: share of a pass spent speeding up, and as much slowing down, 0 to 0.5

  /// Tilt at time t >= 0 [rad]; the first pass starts at t = 0 and takes `pass_duration` [s]. Continuous; nodding has
  /// continuous speed too (trapezoidal speed profile) and starts at centre - amplitude; spinning is at constant speed from 0
  /// and not wrapped.
  double tilt(double t, double pass_duration) const;

  /// True while the tilt grows.
  bool ascending(double t, double pass_duration) const;
};

/// @brief Unit vector of "roll" (x), "pitch" (y) or "yaw" (z). @throws std::invalid_argument naming the three.
Eigen::Vector3d axisFromName(const std::string& name);

/// @brief "nodding" or "spinning". @throws std::invalid_argument naming the two.
Motion::Kind motionFromName(const std::string& name);

}  // namespace ppc::sim
