// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/joint_sample.h"

#include <algorithm>
#include <cstddef>

namespace ppc {

JointSample readJointSample(const sensor_msgs::JointState& message, const std::string& joint) {
  JointSample sample;
  const auto found = std::find(message.name.begin(), message.name.end(), joint);
  sample.present = found != message.name.end();
  if (!sample.present) return sample;
  if (message.header.stamp.isZero()) {
    sample.fault = "joint sample without stamp";
  } else if (std::find(found + 1, message.name.end(), joint) != message.name.end()) {
    sample.fault = "joint '" + joint + "' is there twice in one message";
  } else if (message.position.size() != message.name.size()) {
    sample.fault = "as many joint positions as names expected (" + std::to_string(message.position.size()) + " and " +
                   std::to_string(message.name.size()) + ")";
  } else {
    sample.stamp = message.header.stamp.toSec();
    sample.angle = message.position[static_cast<std::size_t>(found - message.name.begin())];
  }
  return sample;
}

}  // namespace ppc
