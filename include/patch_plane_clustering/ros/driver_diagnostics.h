// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/line_accounts.h"
#include "patch_plane_clustering/core/tilt_track.h"

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <cstdint>
#include <string>

namespace ppc {

/// @brief What the driver knows about itself; rates and ages are in wall time, for the clock may stand.
struct DriverHealth {
  std::string scan_topic;           ///< as resolved
  std::string joint_topic;          ///< as resolved
  std::string joint_name;           ///< empty: the tilt comes from tf2
  std::string other_joints;         ///< those of the last message without this joint
  std::uint64_t scans = 0;          ///< messages since start
  std::uint64_t joint_samples = 0;  ///< messages of the joint since start
  double scan_age = 0.0;            ///< since the last message, or since start [s]
  double joint_age = 0.0;           ///< [s]
  double row_age = 0.0;             ///< since the last line that found its pose, or since start [s]
  double sweep_age = 0.0;           ///< since the last image, or since start [s]
  double sweep_timeout = 60.0;      ///< older is worth a warning [s]
  std::string waits_for;            ///< what the oldest waiting line lacks; empty if none waits
  std::uint32_t lost = 0;           ///< scans that never arrived, by their sequence numbers
  std::string mount;                ///< of the laser, in words; empty while it is not known
  bool standing = false;            ///< the tilt does not move
  LineAccounts lines;
  TiltTrack::Counts track;               ///< of the joint's samples, or of tf's
  std::uint64_t bad_joint_messages = 0;  ///< joint messages without stamp or position of the joint
  std::string last_fault;                ///< of a scan or joint message, since the last report
};

/// @brief Writes the driver's diagnostics, comparing with the report before.
class DriverDiagnostics {
 public:
  /// @param elapsed wall time since the last call [s], for the rates
  void write(const DriverHealth& health, double elapsed, diagnostic_updater::DiagnosticStatusWrapper& status);

  /// @brief What a person at the terminal should read of the report just written: trouble that lasts, once in a while; empty
  /// if there is nothing new.
  std::string news(const diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  DriverHealth last_;
  int troubled_reports_ = 0;  // in a row
};

}  // namespace ppc
