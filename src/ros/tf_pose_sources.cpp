// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/tf_pose_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ppc {
namespace {

constexpr double kNoTilt = std::numeric_limits<double>::quiet_NaN();
constexpr double kSameTilt = 1e-6;  // [rad]

}  // namespace

double twistAngle(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis) {
  return std::remainder(2.0 * std::atan2(rotation.vec().dot(axis), rotation.w()), 2.0 * M_PI);
}

TfPoseSource::TfPoseSource(const Eigen::Vector3d& axis, TransformTrack base_from_laser, const TiltTrackOptions& options,
                           double max_wait)
    : axis_(axis.normalized()),
      transforms_(std::move(base_from_laser)),
      tilts_(options),
      most_samples_(options.capacity),
      max_wait_(max_wait) {}

double TfPoseSource::tiltOf(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond rotation(transform.linear());
  if (!first_) {
    first_ = rotation;
    // A laser mounted half a turn about a line across the axis has no twist of its own; then the first pose is zero.
    const bool defined = std::hypot(rotation.w(), rotation.vec().dot(axis_)) > 0.05;
    first_tilt_ = defined ? twistAngle(rotation, axis_) : 0.0;
  }
  return first_tilt_ + twistAngle(rotation * first_->conjugate(), axis_);
}

void TfPoseSource::add(const StampedTransform& sample) {
  const double tilt = sample.transform.matrix().allFinite() ? tiltOf(sample.transform) : kNoTilt;
  if (!samples_.empty() && sample.stamp < samples_.back().stamp) samples_.clear();  // tf has forgotten all
  samples_.push_back({sample.stamp, tilt});
  if (samples_.size() > most_samples_) samples_.pop_front();
  tilts_.add(sample.stamp, tilt);
}

PoseStatus TfPoseSource::judge(const Sample& sample) const {
  double tilt = 0.0;
  const PoseStatus status = tiltAt(tilts_, sample.stamp, max_wait_, tilt);
  if (status != PoseStatus::kReady) return status;
  return std::abs(std::remainder(sample.tilt - tilt, 2.0 * M_PI)) < kSameTilt ? status : PoseStatus::kTiltGap;
}

PoseStatus TfPoseSource::judge(double stamp, double& tilt) const {
  const PoseStatus status = tiltAt(tilts_, stamp, max_wait_, tilt);
  if (status != PoseStatus::kReady) return status;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp,
                                      [](const Sample& sample, double t) { return sample.stamp < t; });
  if (after == samples_.end()) return PoseStatus::kWait;
  const PoseStatus after_it = judge(*after);
  if (after_it != PoseStatus::kReady || after->stamp == stamp || after == samples_.begin()) return after_it;
  return judge(*(after - 1));
}

PoseStatus TfPoseSource::at(double stamp, LaserPose& pose) {
  Eigen::Isometry3d transform;
  const PoseStatus known = transforms_.at(stamp, transform);
  for (const StampedTransform& sample : transforms_.fresh()) add(sample);
  if (known != PoseStatus::kReady) return known;
  double tilt = 0.0;
  const PoseStatus judged = samples_.empty() ? known : judge(stamp, tilt);  // static: it has no samples
  if (judged == PoseStatus::kWait) return PoseStatus::kWaitTransform;
  if (judged == PoseStatus::kNoTilt) return PoseStatus::kNoTransform;
  if (judged != PoseStatus::kReady) return judged;
  pose.pose = transform;
  pose.base = Eigen::Isometry3d::Identity();
  pose.tilt = tilt + std::remainder(tiltOf(transform) - tilt, 2.0 * M_PI);
  return PoseStatus::kReady;
}

void TfPoseSource::resetClock(double stamp) {
  transforms_.reset();
  samples_.clear();
  tilts_.resetClock(stamp);
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
