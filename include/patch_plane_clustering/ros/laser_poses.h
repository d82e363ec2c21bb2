// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/driver_options.h"
#include "patch_plane_clustering/ros/mount_finder.h"
#include "patch_plane_clustering/ros/tf_pose_sources.h"

#include <memory>
#include <string>

namespace ppc {

/// @brief The driver's pose source: joint or tf, on a base that stands or moves, as its options say. Not thread-safe.
class LaserPoses : public PoseSource {
 public:
  /// @param buffer may be null if needsTf(options) is false; must outlive this
  LaserPoses(DriverOptions options, tf2::BufferCore* buffer);

  static bool needsTf(const DriverOptions& options);

  /// @brief To be set once, before any pose is known.
  void setLaserFrame(const std::string& frame);
  const std::string& laserFrame() const { return laser_frame_; }

  /// The joint, or null if the tilt comes from tf.
  TiltPoseSource* joint() const { return joint_.get(); }

  /// What is known of the tilt, by the joint or by tf; null if no laser frame is set, which tf needs.
  const TiltTrack* tilts() const { return joint_ ? &joint_->track() : tf_ ? &tf_->tilts() : nullptr; }

  /// @brief Looks for the laser's mount in tf, if it is to be found there. @param give_up take the best guess, or none
  /// @return a sentence when the mount has just been settled, else empty.
  std::string settleMount(bool give_up);
  bool mountKnown() const { return !joint_ || joint_->mount().has_value(); }

  PoseStatus at(double stamp, LaserPose& pose) override {
    return source_ ? source_->at(stamp, pose) : PoseStatus::kWaitTransform;
  }
  std::uint64_t jumps() const override { return source_ ? source_->jumps() : 0; }
  bool jumpedBetween(double from, double to) const override { return source_ && source_->jumpedBetween(from, to); }
  std::uint64_t clockResets() const override { return source_ ? source_->clockResets() : 0; }
  void resetClock(double stamp) override;

  /// @brief The transforms that are needed, in words: "tilt_base <- laser".
  std::string transforms() const;

 private:
  DriverOptions options_;
  tf2::BufferCore* buffer_;
  std::string laser_frame_;
  std::unique_ptr<TiltPoseSource> joint_;
  std::unique_ptr<TfPoseSource> tf_;
  std::unique_ptr<MovingBaseSource> moving_;
  std::unique_ptr<MountFinder> mount_finder_;
  PoseSource* source_ = nullptr;  // one of those above
};

/// @brief "lever_arm [x, y, z] m, mount_rpy [r, p, y] rad", as the parameters are given.
std::string describeMount(const Eigen::Isometry3d& mount);

}  // namespace ppc
