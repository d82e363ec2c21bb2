// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/transform_track.h"

#include <deque>
#include <optional>

namespace ppc {

/// @brief Pose of the laser from tf2 alone: the transform is taken as it is, and the tilt, by which rows are sorted, is its
/// rotation about the axis: absolute if the laser's mount leaves that defined, else counted from the first pose.
///
/// Where a TiltTrack of the samples has no tilt, there is no pose: samples are missing while the motor may turn, the angle
/// jumps, or it was frozen. Nor is there any beside a sample that the TiltTrack has left out, with which tf2 interpolates.
class TfPoseSource : public PoseSource {
 public:
  /// @param max_wait as of base_from_laser [s]
  TfPoseSource(const Eigen::Vector3d& axis, TransformTrack base_from_laser, const TiltTrackOptions& options = {},
               double max_wait = 5.0);
  PoseStatus at(double stamp, LaserPose& pose) override;
  std::uint64_t jumps() const override { return tilts_.counts().jumps; }
  bool jumpedBetween(double from, double to) const override { return tilts_.jumpedBetween(from, to); }
  std::uint64_t clockResets() const override { return tilts_.counts().clock_resets; }
  void resetClock(double stamp) override;

  const TiltTrack& tilts() const { return tilts_; }

 private:
  struct Sample {
    double stamp;
    double tilt;  // NaN: it cannot be used
  };
  double tiltOf(const Eigen::Isometry3d& transform);  // within half a turn of the first [rad]
  void add(const StampedTransform& sample);
  PoseStatus judge(const Sample& sample) const;
  PoseStatus judge(double stamp, double& tilt) const;

  Eigen::Vector3d axis_;
  TransformTrack transforms_;
  TiltTrack tilts_;
  std::deque<Sample> samples_;  // as tf2 has them: those that tilts_ leaves out as well
  std::size_t most_samples_;
  double max_wait_;
  std::optional<Eigen::Quaterniond> first_;
  double first_tilt_ = 0.0;
};

/// @brief Adds the motion of the base, from tf2, to another source: poses come out in the fixed frame.
class MovingBaseSource : public PoseSource {
 public:
  /// @param laser must outlive this
  MovingBaseSource(PoseSource& laser, TransformTrack fixed_from_base);
  PoseStatus at(double stamp, LaserPose& pose) override;
  std::uint64_t jumps() const override { return laser_.jumps(); }
  bool jumpedBetween(double from, double to) const override { return laser_.jumpedBetween(from, to); }
  std::uint64_t clockResets() const override { return laser_.clockResets(); }
  void resetClock(double stamp) override {
    laser_.resetClock(stamp);
    track_.reset();
  }

 private:
  PoseSource& laser_;
  TransformTrack track_;
};

/// @brief Angle of the twist of `rotation` about the unit vector `axis`, in (-pi, pi] [rad].
double twistAngle(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis);

}  // namespace ppc
