// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/transform_track.h"

#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <tf2/exceptions.h>
#include <utility>

namespace ppc {
namespace {

constexpr std::size_t kMostGaps = 16;

}  // namespace

TransformTrack::TransformTrack(tf2::BufferCore& buffer, std::string target_frame, std::string source_frame, double max_gap,
                               double max_wait)
    : buffer_(buffer),
      target_(std::move(target_frame)),
      source_(std::move(source_frame)),
      max_gap_(max_gap),
      max_wait_(max_wait),
      watch_(buffer, target_, source_) {}

void TransformTrack::reset() {
  watch_.reset();
  fresh_.clear();
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

void TransformTrack::look() {
  fresh_ = watch_.take();
  for (const StampedTransform& sample : fresh_) {
    if (sample.stamp < newest_) gaps_.clear();  // the clock jumped back and tf has forgotten all
    if (newest_ > 0.0 && sample.stamp - newest_ > max_gap_) gaps_.push_back({newest_, sample.stamp});
    if (gaps_.size() > kMostGaps) gaps_.pop_front();
    newest_ = sample.stamp;
  }
}

PoseStatus TransformTrack::at(double stamp, Eigen::Isometry3d& transform) {
  look();
  // A sample that tf2 has but this has not looked at yet may end a hole: until then it is not there.
  const bool is_static = newest_ < 0.0 && newestStamp() == 0.0;
  if (newest_ < 0.0 && !is_static) return PoseStatus::kWaitTransform;
  if (!is_static && stamp > newest_) {
    return stamp - newest_ > max_wait_ ? PoseStatus::kNoTransform : PoseStatus::kWaitTransform;
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
