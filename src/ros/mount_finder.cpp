// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/mount_finder.h"

#include <cmath>

namespace ppc {
namespace {

constexpr double kOtherTilt = 0.01;      // a tilt this far from the first is a second opinion [rad]
constexpr double kSameDistance = 0.002;  // [m]
constexpr double kSameAngle = 0.005;     // half of kOtherTilt: a tree that stands still differs by at least that [rad]

}  // namespace

bool MountFinder::look(const TiltPoseSource& joint) {
  if (joint.track().empty()) return false;
  const double newest = track_.newestStamp();
  if (newest < 0.0) return false;
  const double stamp = newest > 0.0 ? newest : joint.track().newestStamp();
  double tilt = 0.0;
  Eigen::Isometry3d transform;
  if (joint.track().lookup(stamp, tilt) != TiltTrack::Status::kReady) return false;
  if (track_.at(stamp, transform) != PoseStatus::kReady) return false;
  const Eigen::Isometry3d mount = joint.tilting(tilt).inverse() * transform;
  if (!mount_) {
    mount_ = mount;
    tilt_ = tilt;
    return false;
  }
  if (std::abs(tilt - tilt_) < kOtherTilt) return false;
  const Eigen::Isometry3d difference = mount_->inverse() * mount;
  contradicted_ =
      difference.translation().norm() > kSameDistance || Eigen::AngleAxisd(difference.linear()).angle() > kSameAngle;
  return true;
}

}  // namespace ppc
