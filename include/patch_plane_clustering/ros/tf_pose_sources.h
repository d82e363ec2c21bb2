// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/ros/transform_track.h"

#include <optional>

namespace ppc {

/// @brief Pose of the laser from tf2 alone: the transform is taken as it is, and the tilt, by which rows are sorted, is its
/// rotation about the axis: absolute if the laser's mount leaves that defined, else counted from the first pose.
class TfPoseSource : public PoseSource {
 public:
  TfPoseSource(const Eigen::Vector3d& axis, TransformTrack base_from_laser);
  PoseStatus at(double stamp, LaserPose& pose) override;
  void resetClock(double /*stamp*/) override { track_.reset(); }

 private:
  Eigen::Vector3d axis_;
  TransformTrack track_;
  std::optional<Eigen::Quaterniond> first_;
  double first_tilt_ = 0.0;
  double last_tilt_ = 0.0;
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
