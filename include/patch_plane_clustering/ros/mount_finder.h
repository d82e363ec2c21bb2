// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/transform_track.h"

#include <optional>

namespace ppc {

/// @brief Finds how the laser sits on the tilting frame, from tf2: the transform base <- laser with the joint's tilt
/// removed.
///
/// It must come out the same at two tilts, for a tree that does not follow the joint gives a different mount at each. Not
/// thread-safe.
class MountFinder {
 public:
  explicit MountFinder(TransformTrack base_from_laser) : track_(std::move(base_from_laser)) {}

  /// @brief Looks at the newest transform. @return true once the mount is confirmed or contradicted: no need to look again.
  bool look(const TiltPoseSource& joint);

  /// @brief The mount, or the best guess at it; empty if tf had none, or contradicts the joint.
  std::optional<Eigen::Isometry3d> mount() const { return contradicted_ ? std::nullopt : mount_; }
  bool contradicted() const { return contradicted_; }

 private:
  TransformTrack track_;
  std::optional<Eigen::Isometry3d> mount_;
  double tilt_ = 0.0;  // at which mount_ was seen
  bool contradicted_ = false;
};

}  // namespace ppc
