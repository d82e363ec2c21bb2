// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/transform_watch.h"

#include <tf2/exceptions.h>
#include <deque>
#include <mutex>
#include <utility>

namespace ppc {
namespace {

constexpr std::size_t kMostSamples = 8192;

}  // namespace

Eigen::Isometry3d toIsometry(const geometry_msgs::Transform& t) {
  const Eigen::Quaterniond q(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z);
  Eigen::Isometry3d transform(q.normalized());
  transform.translation() = Eigen::Vector3d(t.translation.x, t.translation.y, t.translation.z);
  return transform;
}

class TransformWatch::Samples {
 public:
  Samples(const tf2::BufferCore& buffer, std::string target_frame, std::string source_frame)
      : buffer_(buffer), target_(std::move(target_frame)), source_(std::move(source_frame)) {}

  void look() {
    const std::lock_guard<std::mutex> lock(mutex_);  // before the buffer is asked: else a newer sample might come first
    geometry_msgs::TransformStamped newest;
    try {
      newest = buffer_.lookupTransform(target_, source_, ros::Time());
    } catch (const tf2::TransformException&) {
      return;  // not known yet
    }
    const double stamp = newest.header.stamp.toSec();
    if (stamp == last_) return;  // another transform of the tree
    last_ = stamp;
    fresh_.push_back({stamp, toIsometry(newest.transform)});
    if (fresh_.size() > kMostSamples) fresh_.pop_front();
  }

  std::vector<StampedTransform> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<StampedTransform> taken(fresh_.begin(), fresh_.end());
    fresh_.clear();
    return taken;
  }

  void reset() {
    const std::lock_guard<std::mutex> lock(mutex_);
    fresh_.clear();
    last_ = kStatic;
  }

 private:
  static constexpr double kStatic = 0.0;  // the stamp that tf2 gives where nothing moves

  const tf2::BufferCore& buffer_;
  std::string target_, source_;
  std::mutex mutex_;
  std::deque<StampedTransform> fresh_;
  double last_ = kStatic;
};

// The listener is marked as internal to tf, whose buffer is built on it; nothing else tells of samples.
TransformWatch::TransformWatch(tf2::BufferCore& buffer, const std::string& target_frame, const std::string& source_frame)
    : samples_(std::make_shared<Samples>(buffer, target_frame, source_frame)),
      connection_(buffer._addTransformsChangedListener([samples = samples_] { samples->look(); })) {
  samples_->look();
}

std::vector<StampedTransform> TransformWatch::take() { return samples_->take(); }

void TransformWatch::reset() { samples_->reset(); }

}  // namespace ppc
