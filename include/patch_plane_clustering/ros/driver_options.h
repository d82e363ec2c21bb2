// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/sweep_assembler.h"
#include "patch_plane_clustering/core/tilt_track.h"
#include "patch_plane_clustering/ros/parameters.h"

#include <optional>
#include <string>

namespace ppc {

/// @brief Parameters of the driver nodelet; names as on the parameter server unless told.
struct DriverOptions {
  std::string joint_name;                           ///< empty: the tilt comes from tf2
  std::string base_frame = "tilt_base";             ///< frame of the images; its origin lies on the tilt axis
  std::string laser_frame;                          ///< frame of the scans to use; empty: that of the first scan
  std::string fixed_frame;                          ///< compensate the base's motion in this frame; empty: do not
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< of the tilt: roll, pitch or yaw, or the opposite ("-pitch")
  std::optional<Eigen::Isometry3d> mount;           ///< lever_arm and mount_rpy; empty: from tf2
  double mount_timeout = 2.0;                       ///< wall time to wait for tf2 to tell the mount [s]
  double idle_timeout = 2.0;                        ///< wall time without a new row after which the sweep is closed [s]
  double sweep_timeout = 60.0;                      ///< wall time without a sweep after which diagnostics warn [s]
  double time_offset = 0.0;                         ///< added to the stamps of scans [s]
  bool foresee = true;                              ///< publish sweeps that seem to have ended, before that is certain
  SweepOptions sweep;                               ///< motion, turn, turn_hysteresis, min_lines, ...
  TiltTrackOptions track;                           ///< max_joint_gap, max_joint_speed
};

/// @brief Reads every parameter of the driver. Bad values are in reader.errors().
DriverOptions readDriverOptions(ParameterReader& reader);

}  // namespace ppc
