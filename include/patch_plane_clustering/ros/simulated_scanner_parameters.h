// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/ros/parameters.h"
#include "patch_plane_clustering/ros/simulated_messages.h"
#include "patch_plane_clustering/sim/scanner.h"

#include <cstdint>

namespace ppc {

/// @brief Private parameters of the SimulatedScanner nodelet.
struct SimulatedScannerParameters {
  std::string scene = "office";  ///< scene: see sim::sceneNames()
  std::uint64_t seed = 1;        ///< seed: of scene and errors, from 0
  sim::ScannerOptions scanner;  ///< sensor, motion (nodding, spinning), axis (roll, pitch, yaw), amplitude [rad], pass_angle
                                ///< [rad], lines_per_pass, lever_arm [x, y, z] [m], mount_rpy [roll, pitch, yaw] [rad],
                                ///< joint_rate [Hz], exact, realistic (else the data sheet's errors),
                                ///< noise_scale and every other field of sim::ErrorModel by its name
  SimulatedNames names;         ///< base_frame, laser_frame, joint_name
  double real_time_factor = 1.0;  ///< real_time_factor: simulated seconds a second; as fast as it can render if that is less
  int replay_passes = 2;          ///< replay_passes: render so many passes, then repeat them; 0 = never repeat; even
  bool publish_clock = false;     ///< publish_clock: /clock, for use_sim_time
  bool publish_tf = false;        ///< publish_tf: base_frame -> laser_frame at every joint sample
  double joint_drop_rate = 0.0;   ///< joint_drop_rate: share of joint samples that get lost, 0..1
  double scan_drop_rate = 0.0;    ///< scan_drop_rate: share of lines that get lost, 0..1
  double joint_delay = 0.0;       ///< joint_delay: joint samples come this late, with right stamps [s]
};

/// @brief Reads and checks them; what is wrong is in the reader's errors(), with the default in its place.
SimulatedScannerParameters readSimulatedScannerParameters(ParameterReader& reader);

}  // namespace ppc
