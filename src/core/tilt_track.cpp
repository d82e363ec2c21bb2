// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/tilt_track.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ppc {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr double kAngleSlack = 0.05;        // encoder noise must not look like speed when two stamps nearly coincide [rad]
constexpr std::size_t kConfirmations = 3;   // samples in a row that make a jump credible
constexpr double kFarBack = 1.0;            // [s]
constexpr double kAlike = 1e-7;             // [rad]
constexpr std::size_t kFrozenSteps = 2;     // steps without motion that may be a frozen encoder
constexpr std::size_t kSteadySteps = 3;     // steps before them that tell the speed
constexpr std::size_t kUsualIntervals = 8;  // intervals that tell the usual one
constexpr std::size_t kNextIntervals = 3;   // where there are none before, the shortest of those after tells it
constexpr double kMissing = 1.5;            // of the usual interval: one that is longer lacks samples
constexpr double kMostAngle = 1e9;          // beyond, an angle has no digits left for a part of a turn [rad]

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
  // Whole turns are added to the sample's own angle: the last bit of an angle must not depend on the samples before it.
  if (!samples_.empty()) angle += kTurn * std::round((samples_.back().angle - angle) / kTurn);
  samples_.push_back({sample.stamp, angle, after_jump, false});
  while (samples_.size() > std::max<std::size_t>(2, options_.capacity)) samples_.pop_front();
  ++counts_.accepted;
}

// Index of the first of the newest samples that are all alike: there the motor was seen to move last.
std::size_t TiltTrack::frozenFrom() const {
  std::size_t first = samples_.size() - 1;
  while (first > 0 && std::abs(samples_[first - 1].angle - samples_.back().angle) <= kAlike) --first;
  return first;
}

// True if the newest samples are alike but the motor went on as before, which `sample` shows.
bool TiltTrack::thawsWith(const Sample& sample) const {
  const std::size_t last = samples_.size() - 1;
  if (last < kFrozenSteps + kSteadySteps || std::abs(samples_[last - 1].angle - samples_[last].angle) > kAlike ||
      std::abs(std::remainder(sample.angle - samples_[last].angle, kTurn)) <= kAlike) {
    return false;
  }
  const std::size_t first = frozenFrom();
  if (last - first < kFrozenSteps || first < kSteadySteps) return false;
  const Sample& begin = samples_[first - kSteadySteps];
  const Sample& stop = samples_[first];
  const double speed = (stop.angle - begin.angle) / (stop.stamp - begin.stamp);
  for (std::size_t i = first - kSteadySteps + 1; i <= first; ++i) {
    const double step = samples_[i].angle - samples_[i - 1].angle;
    const double steady = speed * (samples_[i].stamp - samples_[i - 1].stamp);
    if (std::abs(step - steady) > 0.5 * std::abs(steady)) return false;
  }
  const double leap = std::remainder(sample.angle - stop.angle, kTurn);
  const double foreseen = speed * (sample.stamp - stop.stamp);
  const double one_step = speed * (sample.stamp - samples_[last].stamp);
  return std::abs(leap) > 3.0 * std::abs(one_step) && std::abs(leap - foreseen) <= 0.5 * std::abs(foreseen);
}

void TiltTrack::discardFrozen() {
  for (std::size_t i = frozenFrom() + 1; i < samples_.size(); ++i) samples_[i].frozen = samples_[i].after_jump = true;
}

void TiltTrack::resetClock(double stamp) {
  if (samples_.empty() || samples_.back().stamp <= stamp + kFarBack) return;
  samples_.clear();
  suspects_.clear();
  older_.clear();
  ++counts_.clock_resets;
}

// Several samples in a row that are older than the newest, each later than the one before: the clock was set back a little.
bool TiltTrack::turnsBack(const Sample& sample) {
  ++counts_.not_newer;
  if (!older_.empty() && sample.stamp <= older_.back().stamp) older_.clear();
  if (sample.stamp < samples_.back().stamp) older_.push_back(sample);
  return older_.size() >= kConfirmations;
}

void TiltTrack::add(double stamp, double angle) {
  if (!std::isfinite(stamp) || !(std::abs(angle) <= kMostAngle)) {
    ++counts_.not_finite;
    return;
  }
  const Sample sample{stamp, angle, false, false};
  if (samples_.empty()) return append(sample, false);

  const double dt = stamp - samples_.back().stamp;
  const bool far_back = dt < -kFarBack;
  if (dt <= 0.0 && !far_back) {
    if (!turnsBack(sample)) return;
    samples_.clear();
    ++counts_.clock_resets;
    counts_.not_newer -= older_.size();
    for (const Sample& older : older_) append(older, false);
    older_.clear();
    return;
  }
  older_.clear();
  if (!far_back && follows(samples_.back(), sample)) {
    counts_.implausible += suspects_.size();
    suspects_.clear();
    const bool thaws = thawsWith(sample);
    if (thaws) {
      discardFrozen();
      ++counts_.jumps;
    }
    return append(sample, thaws);
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
  } else if (suspects_.front().stamp - samples_.back().stamp <= options_.max_gap) {
    discardFrozen();
    ++counts_.jumps;
  }
  for (std::size_t i = 0; i < suspects_.size(); ++i) append(suspects_[i], i == 0);
  suspects_.clear();
}

// The usual interval before the one that ends with the sample of index `after`; 0 if there are none. [s]
double TiltTrack::usualIntervalBefore(std::size_t after) const {
  std::array<double, kUsualIntervals> intervals;
  std::size_t n = 0;
  for (std::size_t i = after - 1; i > 0 && n < intervals.size() && !samples_[i].after_jump; --i) {
    intervals[n++] = samples_[i].stamp - samples_[i - 1].stamp;
  }
  if (n == 0) return 0.0;
  // A quarter of them tells the usual one: others may be gaps as well.
  const auto usual = intervals.begin() + static_cast<std::ptrdiff_t>((n - 1) / 4);
  std::nth_element(intervals.begin(), usual, intervals.begin() + static_cast<std::ptrdiff_t>(n));
  return *usual;
}

// Whether a straight line between the first two samples, or the first two after a jump, is one across a gap: then nothing
// tells how the motor came to be there.
TiltTrack::Status TiltTrack::judgeFirst(std::size_t after) const {
  const double interval = samples_[after].stamp - samples_[after - 1].stamp;
  for (std::size_t i = after + 1; i <= after + kNextIntervals; ++i) {
    if (i == samples_.size()) return Status::kTooNew;
    if (samples_[i].after_jump || interval > kMissing * (samples_[i].stamp - samples_[i - 1].stamp)) return Status::kGap;
  }
  return Status::kReady;
}

// First of the samples that end with `last`, go back for `span` and have no jump among them.
std::size_t TiltTrack::windowBefore(std::size_t last, double span) const {
  std::size_t first = last;
  while (first > 0 && !samples_[first].after_jump && samples_[last].stamp - samples_[first].stamp < span) --first;
  return first;
}

// Last of the samples that begin with `first`, go on for `span` and have no jump among them; past the newest if that is
// not known yet.
std::size_t TiltTrack::windowAfter(std::size_t first, double span) const {
  std::size_t last = first;
  while (samples_[last].stamp - samples_[first].stamp < span) {
    if (last + 1 == samples_.size()) return samples_.size();
    if (samples_[last + 1].after_jump) break;
    ++last;
  }
  return last;
}

// How far the samples up to the one of index `last` are from the straight lines between their neighbours, most of them:
// coarse steps of an encoder, jitter of its stamps. [rad]
double TiltTrack::coarsenessBefore(std::size_t last) const {
  std::array<double, kUsualIntervals> residuals;
  std::size_t n = 0;
  for (std::size_t i = last; n < residuals.size() && i > 1 && !samples_[i].after_jump && !samples_[i - 1].after_jump; --i) {
    const Sample &a = samples_[i - 2], &b = samples_[i - 1], &c = samples_[i];
    residuals[n++] = std::abs(a.angle + (c.angle - a.angle) * (b.stamp - a.stamp) / (c.stamp - a.stamp) - b.angle);
  }
  if (n == 0) return 0.0;
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>((n - 1) / 2);
  std::nth_element(residuals.begin(), middle, residuals.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

// Whether a straight line across the gap before the sample of index `after` is near enough to the motion.
TiltTrack::Status TiltTrack::judgeGap(std::size_t after) const {
  const std::size_t before = after - 1;
  const double gap = samples_[after].stamp - samples_[before].stamp;
  const double span = 0.99 * gap;  // as many intervals, though stamps are rounded
  const std::size_t first = windowBefore(before, span), last = windowAfter(after, span);
  if (last == samples_.size()) return Status::kTooNew;
  if (first == before || last == after) return Status::kGap;
  const auto speed = [this](std::size_t a, std::size_t b) {
    return (samples_[b].angle - samples_[a].angle) / (samples_[b].stamp - samples_[a].stamp);
  };
  const double chord = speed(before, after);
  const double entry = speed(first, before) - chord, exit = speed(after, last) - chord;
  double bend = 0.0;
  for (const double u : {0.25, 0.5, 0.75}) {
    bend = std::max(bend, gap * std::abs(entry * u * (1.0 - u) * (1.0 - u) - exit * u * u * (1.0 - u)));
  }
  return bend <= std::max(options_.max_bend, coarsenessBefore(before)) ? Status::kReady : Status::kGap;
}

bool TiltTrack::jumpedBetween(double from, double to) const {
  auto sample =
      std::upper_bound(samples_.begin(), samples_.end(), from, [](double t, const Sample& s) { return t < s.stamp; });
  for (; sample != samples_.end() && sample->stamp <= to; ++sample) {
    if (sample->after_jump && sample != samples_.begin()) return true;
  }
  return false;
}

TiltTrack::Status TiltTrack::lookup(double stamp, double& angle) const {
  if (samples_.empty() || stamp > samples_.back().stamp) return Status::kTooNew;
  if (!(stamp >= samples_.front().stamp)) return Status::kTooOld;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp,
                                      [](const Sample& sample, double t) { return sample.stamp < t; });
  if (after->frozen) return Status::kGap;
  if (after->stamp == stamp) {
    angle = after->angle;
    return Status::kReady;
  }
  const Sample& before = *(after - 1);
  if (after->after_jump || after->stamp - before.stamp > options_.max_gap) return Status::kGap;
  const auto index = static_cast<std::size_t>(after - samples_.begin());
  const double usual = usualIntervalBefore(index);
  const Status status = usual == 0.0                                     ? judgeFirst(index)
                        : after->stamp - before.stamp > kMissing * usual ? judgeGap(index)
                                                                         : Status::kReady;
  if (status != Status::kReady) return status;
  angle = before.angle + (after->angle - before.angle) * (stamp - before.stamp) / (after->stamp - before.stamp);
  return Status::kReady;
}

}  // namespace ppc
