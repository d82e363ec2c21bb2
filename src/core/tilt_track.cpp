// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/tilt_track.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr double kAngleSlack = 0.05;       // encoder noise must not look like speed when two stamps nearly coincide [rad]
constexpr std::size_t kConfirmations = 3;  // samples in a row that make a jump credible

}  // namespace

TiltTrack::TiltTrack(const TiltTrackOptions& options) : options_(options) {}

bool TiltTrack::follows(const Sample& previous, const Sample& next) const {
  const double dt = next.stamp - previous.stamp;
  const double step = std::remainder(next.angle - previous.angle, kTurn);
  return dt <= std::max(1.0, 2.0 * options_.max_gap) &&
         std::abs(step) <= options_.max_speed * std::max(dt, 0.0) + kAngleSlack;
}

void TiltTrack::append(const Sample& sample, bool after_jump) {
  double angle = sample.angle;
  if (!samples_.empty()) angle = samples_.back().angle + std::remainder(angle - samples_.back().angle, kTurn);
  samples_.push_back({sample.stamp, angle, after_jump});
  while (samples_.size() > std::max<std::size_t>(2, options_.capacity)) samples_.pop_front();
  ++counts_.accepted;
}

void TiltTrack::add(double stamp, double angle) {
  if (!std::isfinite(stamp) || !std::isfinite(angle)) {
    ++counts_.not_finite;
    return;
  }
  const Sample sample{stamp, angle, false};
  if (samples_.empty()) return append(sample, false);

  const double dt = stamp - samples_.back().stamp;
  const bool far_back = dt < -1.0;
  if (dt <= 0.0 && !far_back) {
    ++counts_.not_newer;
    return;
  }
  if (!far_back && follows(samples_.back(), sample)) {
    counts_.implausible += suspects_.size();
    suspects_.clear();
    return append(sample, false);
  }
  if (!suspects_.empty() && !(stamp > suspects_.back().stamp && follows(suspects_.back(), sample))) {
    counts_.implausible += suspects_.size();
    suspects_.clear();
  }
  suspects_.push_back(sample);
  if (suspects_.size() < kConfirmations) return;
  if (suspects_.front().stamp <= samples_.back().stamp) {
    samples_.clear();
    ++counts_.clock_resets;
  }
  for (std::size_t i = 0; i < suspects_.size(); ++i) append(suspects_[i], i == 0);
  suspects_.clear();
}

TiltTrack::Status TiltTrack::lookup(double stamp, double& angle) const {
  if (samples_.empty() || stamp > samples_.back().stamp) return Status::kTooNew;
  if (!(stamp >= samples_.front().stamp)) return Status::kTooOld;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp,
                                      [](const Sample& sample, double t) { return sample.stamp < t; });
  if (after->stamp == stamp) {
    angle = after->angle;
    return Status::kReady;
  }
  const Sample& before = *(after - 1);
  if (after->after_jump || after->stamp - before.stamp > options_.max_gap) return Status::kGap;
  angle = before.angle + (after->angle - before.angle) * (stamp - before.stamp) / (after->stamp - before.stamp);
  return Status::kReady;
}

}  // namespace ppc
