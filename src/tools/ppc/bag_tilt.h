// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bag_sweeps.h"

#include <rosbag/bag.h>
#include <Eigen/Geometry>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace ppc {

/// @brief What a first look at a bag finds out about the motor and how the laser sits on it.
struct BagTilt {
  std::string scan;          ///< topic of the lines
  std::string laser_frame;   ///< their frame
  std::string joint_states;  ///< topic of the tilt; empty: the tilt comes from /tf
  std::string joint;         ///< name of the joint on that topic
  std::string base_frame;
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();  ///< laser in the tilting frame
  std::vector<std::pair<double, double>> tilts;             ///< from /tf: stamp [s], angle [rad]
  std::string note;                                         ///< a line for the user about what had to be assumed, or empty
};

/// @brief Finds it. @throws std::runtime_error with the cause (without the file's name).
BagTilt findTilt(const rosbag::Bag& bag, const BagOptions& options);

}  // namespace ppc
