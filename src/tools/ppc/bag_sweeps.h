// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/line_accounts.h"
#include "patch_plane_clustering/core/sweep_assembler.h"

#include <rosbag/message_instance.h>

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace ppc {

/// @brief How to make range images of the lines in a bag. What is left empty is found in the bag itself.
struct BagOptions {
  std::string scan;                ///< LaserScan topic; empty: the only one
  std::string joint_states;        ///< JointState topic; empty: the only one
  std::string joint;               ///< empty: the only joint, or the one that moves most
  bool tilt_from_tf = false;       ///< take the tilt from /tf even if there are joint states
  std::string axis = "pitch";      ///< roll, pitch or yaw; with '-' for the opposite sense
  std::string motion = "nodding";  ///< nodding, half_turn or full_turn
  std::vector<double> lever_arm;   ///< laser in the tilting frame [m]; empty: from /tf
  std::vector<double> mount_rpy;   ///< its rotation [rad]; empty: from /tf
  std::string base_frame;          ///< frame of the images; empty: from /tf
  double time_offset = 0.0;        ///< added to the stamps of scans [s]
  SweepOptions sweep;

  void addTo(CLI::App& command);
};

/// @brief One range image out of a bag.
struct BagSweep {
  Sweep sweep;
  std::string frame_id;
  ros::Time written;  ///< when the message that completed it was recorded
};

/// @brief Reads a bag from its first message to its last and assembles sweeps as the driver nodelet does.
/// @param on_message called with every message, before the sweep that it completes; may be empty
/// @param on_sweep called with every sweep
/// @param on_progress called with the share of messages read, 0..1; may be empty
/// @return where every line went.
/// @throws std::runtime_error naming the file and the cause: no bag, truncated, a topic missing or of the wrong type.
LineAccounts readSweeps(const std::string& path, const BagOptions& options,
                        const std::function<void(const rosbag::MessageInstance&)>& on_message,
                        const std::function<void(BagSweep&&)>& on_sweep, const std::function<void(double)>& on_progress);

/// @brief Draws a bar on stderr if that is a terminal.
void showProgress(double share);

}  // namespace ppc
