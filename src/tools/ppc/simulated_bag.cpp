// SPDX-License-Identifier: BSD-3-Clause
#include "simulated_bag.h"

#include "patch_plane_clustering/ros/simulated_messages.h"

#include <rosbag/bag.h>

namespace patch_plane_clustering {

void writeSimulatedBag(const sim::Scanner& scanner, int passes, const std::string& path) {
  const ros::Time start(1000.0);
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::LZ4);
  sim::JointSample next = scanner.joint(0);
  int joints = 0;
  const auto writeJoint = [&] {
    const ros::Time stamp = start + ros::Duration(next.stamp);
    bag.write("/joint_states", stamp, toJointState(next, start));
    bag.write("/tf", stamp, toTransforms(scanner, next, start));
    next = scanner.joint(++joints);
  };
  const int lines = passes * scanner.options().motion.lines_per_pass;
  for (int i = 0; i < lines; ++i) {
    const sim::ScanLine line = scanner.line(i);
    const double end = line.stamp + scanner.timeIncrement() * static_cast<double>(line.ranges.size());
    while (next.stamp <= end) writeJoint();
    bag.write("/scan", start + ros::Duration(end), toLaserScan(scanner, line, start));
  }
  // A driver needs one more joint sample to place the last beams.
  writeJoint();
  bag.close();
}

}  // namespace patch_plane_clustering
