// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>
#include <functional>

namespace ppc {

/// Runs callbacks until `done` or the time is over [s]. @return done
inline bool waitFor(const std::function<bool()>& done, double seconds = 60.0) {
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && ros::SteadyTime::now() < end) {
    ros::spinOnce();
    if (done()) return true;
    ros::WallDuration(0.005).sleep();
  }
  return false;
}

}  // namespace ppc
