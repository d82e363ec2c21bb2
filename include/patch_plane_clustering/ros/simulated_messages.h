// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/sim/scanner.h"

#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>
#include <string>

namespace ppc {

/// @brief Names that a simulated scanner goes by.
struct SimulatedNames {
  std::string base_frame = "tilt_base";
  std::string laser_frame = "laser";
  std::string joint = "tilt_joint";
};

/// @brief A line as the laser's driver would publish it; stamped with its first beam. `start` is the simulation's time 0.
sensor_msgs::LaserScan toLaserScan(const sim::Scanner& scanner, const sim::ScanLine& line, const ros::Time& start,
                                   const SimulatedNames& names = {});

/// @brief A joint sample as the motor's driver would publish it.
sensor_msgs::JointState toJointState(const sim::JointSample& sample, const ros::Time& start,
                                     const SimulatedNames& names = {});

/// @brief The transform from the base to the laser that follows from a joint sample.
tf2_msgs::TFMessage toTransforms(const sim::Scanner& scanner, const sim::JointSample& sample, const ros::Time& start,
                                 const SimulatedNames& names = {});

}  // namespace ppc
