// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/sim/scanner.h"

#include <rosbag/bag.h>

namespace ppc {

/// @brief Writes what the hardware would publish during `passes` passes: /scan (sensor_msgs/LaserScan, frame laser),
/// /joint_states (tilt_joint, rad), /tf (tilt_base -> laser, at the joint's rate). The clock starts at 1000 s; messages are
/// recorded when the hardware would have them, a scan at its last beam. @throws rosbag::BagException.
void writeSimulatedBag(const sim::Scanner& scanner, int passes, rosbag::Bag& bag);

}  // namespace ppc
