// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/transform_track.h"

#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <tf2/exceptions.h>
#include <utility>

namespace ppc {
namespace {

Eigen::Isometry3d toIsometry(const geometry_msgs::Transform& t) {
  const Eigen::Quaterniond q(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z);
  Eigen::Isometry3d transform(q.normalized());
  transform.translation() = Eigen::Vector3d(t.translation.x, t.translation.y, t.translation.z);
  return transform;
}

}  // namespace

TransformTrack::TransformTrack(const tf2::BufferCore& buffer, std::string target_frame, std::string source_frame,
                               double max_gap, double max_wait)
    : buffer_(buffer),
      target_(std::move(target_frame)),
      source_(std::move(source_frame)),
      max_gap_(max_gap),
      max_wait_(max_wait) {}

void TransformTrack::reset() {
  newest_ = -1.0;
  gaps_.clear();
}

double TransformTrack::newestStamp() const {
  try {
    return buffer_.lookupTransform(target_, source_, ros::Time()).header.stamp.toSec();
  } catch (const tf2::TransformException&) {
    return -1.0;
  }
}

PoseStatus TransformTrack::at(double stamp, Eigen::Isometry3d& transform) {
  const double newest = newestStamp();
  if (newest < newest_) gaps_.clear();  // the clock jumped back and tf has forgotten all
  if (newest_ > 0.0 && newest - newest_ > max_gap_) gaps_.push_back({newest_, newest});
  if (gaps_.size() > 16) gaps_.pop_front();
  newest_ = newest;
  if (newest < 0.0) return PoseStatus::kWaitTransform;
  if (newest > 0.0 && stamp > newest) {
    return stamp - newest > max_wait_ ? PoseStatus::kNoTransform : PoseStatus::kWaitTransform;
  }
  for (const Gap& gap : gaps_) {
    if (gap.from < stamp && stamp < gap.to) return PoseStatus::kTiltGap;
  }
  try {
    transform = toIsometry(buffer_.lookupTransform(target_, source_, toTime(stamp)).transform);
  } catch (const tf2::TransformException&) {
    return PoseStatus::kNoTransform;
  }
  return transform.matrix().allFinite() ? PoseStatus::kReady : PoseStatus::kNoTransform;
}

}  // namespace ppc
