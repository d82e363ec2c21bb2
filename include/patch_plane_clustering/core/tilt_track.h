// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace ppc {

struct TiltTrackOptions {
  double max_gap = 0.5;         ///< never interpolate between samples further apart than this [s]
  double max_speed = 10.0;      ///< a sample that asks for a faster motor is suspect [rad/s]
  std::size_t capacity = 8192;  ///< samples kept; the oldest are forgotten
  double max_bend = 0.0005;     ///< samples missing: no tilt where the motion around says it may be off by more [rad]
};

/// @brief Angle of the tilt joint over time, from its samples.
///
/// Angles are unwrapped across +-pi. A sample that jumps in time (either way) or asks for an impossible speed is suspect: it
/// is used only once two more samples continue it, so that one corrupt sample moves no row. A confirmed jump back in time is
/// a clock reset and clears the track; after any other confirmed jump, lookup() does not interpolate across it.
///
/// A jump of the angle after samples that were all alike means that the encoder was frozen while the motor went on, and so
/// does a smaller leap to where steady motion before the alike samples leads: then there is no tilt for the time between. A
/// motor that moves in steps looks different: it stood before.
///
/// Where samples are missing, a straight line is drawn only if the speeds before and after agree with it: the cubic through
/// both ends with these speeds (Hermite's) may leave it by `max_bend`, or by what a coarse encoder leaves it anyway. So a
/// time in such a gap is told once the samples after it are there, as many as span the gap again. Whether samples are
/// missing between the first two, or the first two after a jump, the three intervals after them tell. Not thread-safe.
class TiltTrack {
 public:
  enum class Status {
    kReady,   ///< interpolated between two bracketing samples
    kTooNew,  ///< later than the newest sample, or than those that judge the gap it lies in: it may come
    kTooOld,  ///< earlier than the oldest sample
    kGap      ///< the bracketing samples are too far apart for the motion, a jump lies between them, or they were frozen
  };
  struct Counts {
    std::uint64_t accepted = 0;
    std::uint64_t not_finite = 0;    ///< NaN or infinite stamp or angle, or an angle beyond 1e9 rad
    std::uint64_t not_newer = 0;     ///< stamp equal to or before the newest one
    std::uint64_t implausible = 0;   ///< suspect samples that nothing confirmed
    std::uint64_t clock_resets = 0;  ///< confirmed jumps back in time
    std::uint64_t jumps = 0;         ///< confirmed jumps of the angle, and leaps after it was frozen
  };

  explicit TiltTrack(const TiltTrackOptions& options = {});

  /// @param stamp [s] @param angle [rad], wrapped or not. Bad samples are counted and ignored.
  void add(double stamp, double angle);

  /// @brief Angle at `stamp` by linear interpolation, never extrapolation; `angle` [rad, unwrapped] is set only for kReady.
  Status lookup(double stamp, double& angle) const;

  /// @brief True if lookup() does not interpolate because of a jump at some time in (from, to] [s].
  bool jumpedBetween(double from, double to) const;

  /// @brief Forgets everything if it is later than `stamp` by a second: the clock has jumped back to there. [s]
  void resetClock(double stamp);

  bool empty() const { return samples_.empty(); }
  double newestStamp() const { return samples_.back().stamp; }  ///< precondition: not empty [s]
  double newestAngle() const { return samples_.back().angle; }  ///< precondition: not empty [rad]
  const Counts& counts() const { return counts_; }

 private:
  struct Sample {
    double stamp;
    double angle;
    bool after_jump;  // nothing is interpolated between this sample and the one before
    bool frozen;      // the angle is not that of its time
  };
  bool follows(const Sample& previous, const Sample& next) const;
  bool turnsBack(const Sample& sample);
  void append(const Sample& sample, bool after_jump);
  double usualIntervalBefore(std::size_t after) const;
  std::size_t windowBefore(std::size_t last, double span) const;
  std::size_t windowAfter(std::size_t first, double span) const;
  double coarsenessBefore(std::size_t last) const;
  Status judgeFirst(std::size_t after) const;
  Status judgeGap(std::size_t after) const;
  std::size_t frozenFrom() const;
  bool thawsWith(const Sample& sample) const;
  void discardFrozen();

  TiltTrackOptions options_;
  std::deque<Sample> samples_;
  std::vector<Sample> suspects_;
  std::vector<Sample> older_;  // samples in a row that are a little older than the newest
  Counts counts_;
};

}  // namespace ppc
