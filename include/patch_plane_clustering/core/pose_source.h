// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace ppc {

/// @brief Where the laser was at one instant.
struct LaserPose {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< laser scan frame in the world
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< base frame in the world; identity where the world is the base
  double tilt = 0.0;                                       ///< rotation about the tilt axis, unwrapped [rad]
};

enum class PoseStatus {
  kReady,       ///< known
  kWait,        ///< not known yet, ask again
  kNoTilt,      ///< no tilt sample before it, or none comes
  kTiltGap,     ///< the tilt samples around it are too far apart
  kNoTransform  ///< a transform is missing for good
};

/// @brief Knows the laser's pose at any time, never by extrapolation.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  /// @brief Sets `pose` only for kReady. @param stamp [s]
  virtual PoseStatus at(double stamp, LaserPose& pose) = 0;
};

}  // namespace ppc
