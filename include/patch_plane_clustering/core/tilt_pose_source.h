// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/pose_source.h"
#include "patch_plane_clustering/core/tilt_track.h"

#include <optional>
#include <string>

namespace ppc {

/// @brief Unit vector of a named tilt axis: roll (x), pitch (y) or yaw (z), with a leading '-' for the opposite sense.
/// @throws std::invalid_argument naming the allowed words.
Eigen::Vector3d tiltAxis(const std::string& name);

/// @brief Tilt at `stamp` [s], set for kReady alone: kWait, kNoTilt or kTiltGap where there is none.
/// @param max_wait a time this much ahead of the newest sample has no tilt [s]
PoseStatus tiltAt(const TiltTrack& track, double stamp, double max_wait, double& tilt);

/// @brief Pose of the laser from its joint angle: R_axis(tilt) * mount, in the non-tilting base frame, whose origin lies on
/// the tilt axis. The mount is the pose of the laser's scan frame in the tilting frame: lever arm [m] and rotation.
class TiltPoseSource : public PoseSource {
 public:
  /// @param max_wait a time this much ahead of the newest sample has no tilt [s]
  TiltPoseSource(const Eigen::Vector3d& axis, const TiltTrackOptions& track_options, double max_wait = 5.0);

  void setMount(const Eigen::Isometry3d& mount) { mount_ = mount; }
  const std::optional<Eigen::Isometry3d>& mount() const { return mount_; }

  TiltTrack& track() { return track_; }
  const TiltTrack& track() const { return track_; }
  /// The tilting frame in the base frame.
  Eigen::Isometry3d tilting(double tilt) const { return Eigen::Isometry3d(Eigen::AngleAxisd(tilt, axis_)); }

  /// Waits while the mount is not set.
  PoseStatus at(double stamp, LaserPose& pose) override;
  std::uint64_t jumps() const override { return track_.counts().jumps; }
  bool jumpedBetween(double from, double to) const override { return track_.jumpedBetween(from, to); }
  std::uint64_t clockResets() const override { return track_.counts().clock_resets; }
  void resetClock(double stamp) override { track_.resetClock(stamp); }

 private:
  Eigen::Vector3d axis_;
  TiltTrack track_;
  double max_wait_;
  std::optional<Eigen::Isometry3d> mount_;
};

}  // namespace ppc
