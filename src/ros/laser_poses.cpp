// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/laser_poses.h"

#include <cmath>
#include <cstdio>
#include <utility>

namespace ppc {

bool LaserPoses::needsTf(const DriverOptions& options) {
  return options.joint_name.empty() || !options.fixed_frame.empty() || !options.mount;
}

LaserPoses::LaserPoses(DriverOptions options, tf2::BufferCore* buffer) : options_(std::move(options)), buffer_(buffer) {
  if (options_.joint_name.empty()) return;
  joint_ = std::make_unique<TiltPoseSource>(options_.axis, options_.track, options_.sweep.max_wait);
  if (options_.mount) joint_->setMount(*options_.mount);
}

void LaserPoses::setLaserFrame(const std::string& frame) {
  laser_frame_ = frame;
  const auto track = [&](const std::string& target, const std::string& source) {
    return TransformTrack(*buffer_, target, source, options_.track.max_gap, options_.sweep.max_wait);
  };
  source_ = joint_.get();
  if (!joint_) {
    tf_ = std::make_unique<TfPoseSource>(options_.axis, track(options_.base_frame, frame), options_.track,
                                         options_.sweep.max_wait);
    source_ = tf_.get();
  } else if (!joint_->mount()) {
    mount_finder_ = std::make_unique<MountFinder>(track(options_.base_frame, frame));
  }
  if (!options_.fixed_frame.empty()) {
    moving_ = std::make_unique<MovingBaseSource>(*source_, track(options_.fixed_frame, options_.base_frame));
    source_ = moving_.get();
  }
}

void LaserPoses::resetClock(double stamp) {
  if (!source_) return;
  // Without simulated time tf2 does not see a clock jump back, and would mix the transforms of both runs. It is cleared
  // first: who watches it must not see samples of the old run after having forgotten that.
  if (buffer_) buffer_->clear();
  source_->resetClock(stamp);
}

std::string LaserPoses::transforms() const {
  std::string names;
  if (!joint_ || !joint_->mount()) names = options_.base_frame + " <- " + laser_frame_;
  if (!options_.fixed_frame.empty())
    names += (names.empty() ? "" : ", ") + options_.fixed_frame + " <- " + options_.base_frame;
  return names;
}

std::string LaserPoses::settleMount(bool give_up) {
  if (!mount_finder_ || (!mount_finder_->look(*joint_) && !give_up)) return {};
  const auto mount = mount_finder_->mount();
  const std::string origin = mount ? "tf"
                             : mount_finder_->contradicted()
                                 ? "default, for tf does not follow joint '" + options_.joint_name + "'"
                                 : "default, for tf does not know " + options_.base_frame + " <- " + laser_frame_;
  joint_->setMount(mount.value_or(Eigen::Isometry3d::Identity()));
  mount_finder_.reset();
  return "laser's mount from " + origin + ": " + describeMount(*joint_->mount());
}

std::string describeMount(const Eigen::Isometry3d& mount) {
  const Eigen::Vector3d arm = mount.translation();
  const Eigen::Matrix3d& r = mount.linear();
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
  const auto rounded = [](double x) { return std::round(x * 1e4) / 1e4 + 0.0; };  // + 0.0 makes -0 plain 0
  char text[160];
  std::snprintf(text, sizeof text, "lever_arm [%.4f, %.4f, %.4f] m, mount_rpy [%.4f, %.4f, %.4f] rad", rounded(arm.x()),
                rounded(arm.y()), rounded(arm.z()), rounded(std::atan2(r(2, 1), r(2, 2))), rounded(pitch),
                rounded(std::atan2(r(1, 0), r(0, 0))));
  return text;
}

}  // namespace ppc
