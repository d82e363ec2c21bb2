// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/sweep_splitter.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kSeemingTurn = 0.25;  // of the hysteresis: less is the noise of most encoders

}  // namespace

SweepSplitter::SweepSplitter(SweepMotion motion, double hysteresis) : motion_(motion), hysteresis_(hysteresis) {}

void SweepSplitter::restart() {
  lines_ = 0;
  direction_ = 0;
  foreseen_ = 0;
}

std::size_t SweepSplitter::feed(double tilt) {
  return motion_ == SweepMotion::kNodding ? feedNodding(tilt) : feedSpinning(tilt);
}

std::size_t SweepSplitter::feedNodding(double tilt) {
  const std::size_t index = lines_++;
  foreseen_ = 0;
  if (index == 0) {
    lowest_ = highest_ = tilt;
    turn_at_ = 0;
    return 0;
  }
  const bool new_extremum = (direction_ >= 0 && tilt >= highest_) || (direction_ <= 0 && tilt <= lowest_);
  lowest_ = std::min(lowest_, tilt);
  highest_ = std::max(highest_, tilt);
  if (new_extremum) turn_at_ = index;
  if (direction_ == 0) {
    // A first sweep that begins within the hysteresis of a turning point keeps those few lines: they are in place all the
    // same.
    if (highest_ - lowest_ > hysteresis_) direction_ = tilt == highest_ ? 1 : -1;
    return 0;
  }
  const double come_back = direction_ > 0 ? highest_ - tilt : tilt - lowest_;
  if (come_back <= hysteresis_) {
    if (come_back > kSeemingTurn * hysteresis_) foreseen_ = turn_at_ + 1;
    return 0;
  }
  const std::size_t completed = turn_at_ + 1;
  lines_ -= completed;
  direction_ = -direction_;
  turn_at_ = lines_ - 1;
  // In the old direction the new sweep's lines are all below the extremum, so the newest line is their other end.
  if (direction_ < 0) {
    lowest_ = tilt;
  } else {
    highest_ = tilt;
  }
  return completed;
}

std::size_t SweepSplitter::feedSpinning(double tilt) {
  const double width = motion_ == SweepMotion::kHalfTurn ? kPi : 2.0 * kPi;
  const auto sectorOf = [width](double at) { return std::floor((at + kPi) / width); };
  const double sector = sectorOf(tilt), step = tilt - latest_;
  const std::size_t before = lines_++;
  latest_ = tilt;
  foreseen_ = 0;
  if (before == 0) {
    sector_ = sector;
    return 0;
  }
  if (sector == sector_) {
    if (sectorOf(tilt + step) != sector) foreseen_ = lines_;
    return 0;
  }
  const double start = sector_ * width - kPi;
  const double fallen_back = direction_ > 0 ? start - tilt : direction_ < 0 ? tilt - (start + width) : width;
  if (fallen_back >= 0.0 && fallen_back <= hysteresis_) return 0;
  direction_ = sector > sector_ ? 1 : -1;
  sector_ = sector;
  lines_ = 1;
  return before;
}

}  // namespace ppc
