// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <cstdint>

namespace ppc {

/// @brief Where the laser was at one instant.
struct LaserPose {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< laser scan frame in the world
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< base frame in the world; identity where the world is the base
  double tilt = 0.0;                                       ///< rotation about the tilt axis, unwrapped [rad]
};

enum class PoseStatus {
  kReady,          ///< known
  kWait,           ///< the tilt is not known yet, ask again
  kWaitTransform,  ///< a transform is not known yet, ask again
  kNoTilt,         ///< no tilt sample before it, or none comes
  kTiltGap,        ///< the tilt samples around it are too far apart
  kNoTransform     ///< a transform is missing for good
};
inline bool waits(PoseStatus status) { return status == PoseStatus::kWait || status == PoseStatus::kWaitTransform; }

/// @brief Knows the laser's pose at any time, never by extrapolation.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  /// @brief Sets `pose` only for kReady. @param stamp [s]
  virtual PoseStatus at(double stamp, LaserPose& pose) = 0;

  /// @brief How often the tilt was seen to jump: poses given for the time before may no longer stand, ask again.
  virtual std::uint64_t jumps() const { return 0; }

  /// @brief True if the tilt jumped after `from` and not after `to` [s]: rows of these two times share no sweep. By stamps
  /// alone, so that it does not matter whether the tilt samples came before the lines or after them.
  virtual bool jumpedBetween(double /*from*/, double /*to*/) const { return false; }

  /// @brief How often the clock of the tilt samples jumped back: times that wait for a pose are of another run.
  virtual std::uint64_t clockResets() const { return 0; }

  /// @brief The lines' clock jumped back to `stamp` [s]: what was known of later times is of another run.
  virtual void resetClock(double /*stamp*/) {}
};

}  // namespace ppc
