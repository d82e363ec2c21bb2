// SPDX-License-Identifier: BSD-3-Clause
#include "simulated_bag.h"

#include "patch_plane_clustering/ros/simulated_messages.h"
#include "patch_plane_clustering/sim/scan_stream.h"

#include <cstdint>

namespace ppc {

void writeSimulatedBag(const sim::Scanner& scanner, int passes, rosbag::Bag& bag) {
  const ros::Time start(1000.0);
  sim::ScanStream stream(scanner, 0);
  // One joint sample more than lines: a driver needs it to place the last beams.
  auto lines = std::int64_t{passes} * scanner.options().motion.lines_per_pass;
  for (bool last = false; !last;) {
    const sim::ScanEvent event = stream.next();
    const ros::Time stamp = start + ros::Duration(event.time);
    if (event.is_line) {
      bag.write("/scan", stamp, toLaserScan(scanner, event.line, start));
      --lines;
      continue;
    }
    bag.write("/joint_states", stamp, toJointState(event.joint, start));
    bag.write("/tf", stamp, toTransforms(scanner, event.joint, start));
    last = lines == 0;
  }
}

}  // namespace ppc
