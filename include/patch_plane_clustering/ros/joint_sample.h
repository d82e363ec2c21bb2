// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/JointState.h>
#include <string>

namespace ppc {

/// @brief What a joint message says of one joint.
struct JointSample {
  bool present = false;  ///< the message names the joint
  std::string fault;     ///< why the rest cannot be used; empty if it can
  double stamp = 0.0;    ///< [s]
  double angle = 0.0;    ///< [rad], any value
};

/// @brief Reads the angle of `joint`. Positions that are not as many as the names, a joint that is
/// named twice, and a zero stamp are faults.
JointSample readJointSample(const sensor_msgs::JointState& message, const std::string& joint);

}  // namespace ppc
