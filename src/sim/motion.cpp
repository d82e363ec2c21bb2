// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/motion.h"

#include <cmath>
#include <stdexcept>

namespace ppc::sim {
namespace {

// Way covered (0 to 1) at phase x of a pass (0 to 1) with a trapezoidal speed profile.
double trapezoid(double x, double share) {
  if (share <= 0.0) return x;
  const double speed = 1.0 / (1.0 - share);  // of the even part, so that the whole way is 1
  if (x < share) return 0.5 * speed * x * x / share;
  if (x > 1.0 - share) return 1.0 - 0.5 * speed * (1.0 - x) * (1.0 - x) / share;
  return speed * (x - 0.5 * share);
}

}  // namespace

double Motion::tilt(double t, double pass_duration) const {
  const double passes = t / pass_duration;
  if (kind == Kind::kSpinning) return pass_angle * passes;
  const double whole = std::floor(passes);
  const double way = trapezoid(passes - whole, turn_share);
  return centre + amplitude * (ascending(t, pass_duration) ? 2.0 * way - 1.0 : 1.0 - 2.0 * way);
}

bool Motion::ascending(double t, double pass_duration) const {
  if (kind == Kind::kSpinning) return pass_angle > 0.0;
  return std::fmod(std::floor(t / pass_duration), 2.0) == 0.0;
}

Eigen::Vector3d axisFromName(const std::string& name) {
  if (name == "roll") return Eigen::Vector3d::UnitX();
  if (name == "pitch") return Eigen::Vector3d::UnitY();
  if (name == "yaw") return Eigen::Vector3d::UnitZ();
  throw std::invalid_argument("axis is '" + name + "', allowed: roll, pitch, yaw");
}

Motion::Kind motionFromName(const std::string& name) {
  if (name == "nodding") return Motion::Kind::kNodding;
  if (name == "spinning") return Motion::Kind::kSpinning;
  throw std::invalid_argument("motion is '" + name + "', allowed: nodding, spinning");
}

}  // namespace ppc::sim
