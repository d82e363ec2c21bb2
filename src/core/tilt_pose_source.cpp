// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/tilt_pose_source.h"

#include <stdexcept>

namespace ppc {

Eigen::Vector3d tiltAxis(const std::string& name) {
  const bool negative = !name.empty() && name[0] == '-';
  const std::string word = negative ? name.substr(1) : name;
  const double sign = negative ? -1.0 : 1.0;
  if (word == "roll") return sign * Eigen::Vector3d::UnitX();
  if (word == "pitch") return sign * Eigen::Vector3d::UnitY();
  if (word == "yaw") return sign * Eigen::Vector3d::UnitZ();
  throw std::invalid_argument("tilt axis '" + name + "' is not roll, pitch, yaw, -roll, -pitch or -yaw");
}

TiltPoseSource::TiltPoseSource(const Eigen::Vector3d& axis, const TiltTrackOptions& track_options, double max_wait)
    : axis_(axis.normalized()), track_(track_options), max_wait_(max_wait) {}

PoseStatus tiltAt(const TiltTrack& track, double stamp, double max_wait, double& tilt) {
  switch (track.lookup(stamp, tilt)) {
    case TiltTrack::Status::kTooNew:
      return track.empty() || stamp - track.newestStamp() <= max_wait ? PoseStatus::kWait : PoseStatus::kNoTilt;
    case TiltTrack::Status::kTooOld:
      return PoseStatus::kNoTilt;
    case TiltTrack::Status::kGap:
      return PoseStatus::kTiltGap;
    default:
      return PoseStatus::kReady;
  }
}

PoseStatus TiltPoseSource::at(double stamp, LaserPose& pose) {
  double tilt = 0.0;
  const PoseStatus status = tiltAt(track_, stamp, max_wait_, tilt);
  if (status != PoseStatus::kReady) return status;
  if (!mount_) return PoseStatus::kWaitTransform;
  pose.pose = tilting(tilt) * *mount_;
  pose.base = Eigen::Isometry3d::Identity();
  pose.tilt = tilt;
  return PoseStatus::kReady;
}

}  // namespace ppc
