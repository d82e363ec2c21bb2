// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/tf_pose_sources.h"

#include <cmath>
#include <utility>

namespace ppc {

double twistAngle(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis) {
  return std::remainder(2.0 * std::atan2(rotation.vec().dot(axis), rotation.w()), 2.0 * M_PI);
}

TfPoseSource::TfPoseSource(const Eigen::Vector3d& axis, TransformTrack base_from_laser)
    : axis_(axis.normalized()), track_(std::move(base_from_laser)) {}

PoseStatus TfPoseSource::at(double stamp, LaserPose& pose) {
  Eigen::Isometry3d transform;
  const PoseStatus status = track_.at(stamp, transform);
  if (status != PoseStatus::kReady) return status;
  const Eigen::Quaterniond rotation(transform.linear());
  if (!first_) {
    first_ = rotation;
    // A laser mounted half a turn about a line across the axis has no twist of its own; then the first pose is zero.
    const bool defined = std::hypot(rotation.w(), rotation.vec().dot(axis_)) > 0.05;
    first_tilt_ = last_tilt_ = defined ? twistAngle(rotation, axis_) : 0.0;
  }
  const double tilt = first_tilt_ + twistAngle(rotation * first_->conjugate(), axis_);
  last_tilt_ += std::remainder(tilt - last_tilt_, 2.0 * M_PI);
  pose.pose = transform;
  pose.base = Eigen::Isometry3d::Identity();
  pose.tilt = last_tilt_;
  return PoseStatus::kReady;
}

MovingBaseSource::MovingBaseSource(PoseSource& laser, TransformTrack fixed_from_base)
    : laser_(laser), track_(std::move(fixed_from_base)) {}

PoseStatus MovingBaseSource::at(double stamp, LaserPose& pose) {
  LaserPose in_base;
  const PoseStatus laser_status = laser_.at(stamp, in_base);
  if (laser_status != PoseStatus::kReady) return laser_status;
  Eigen::Isometry3d base;
  const PoseStatus base_status = track_.at(stamp, base);
  if (base_status != PoseStatus::kReady) return waits(base_status) ? base_status : PoseStatus::kNoTransform;
  pose.tilt = in_base.tilt;
  pose.base = base;
  pose.pose = base * in_base.pose;
  return PoseStatus::kReady;
}

}  // namespace ppc
