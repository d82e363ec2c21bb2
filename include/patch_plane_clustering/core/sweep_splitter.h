// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace ppc {

/// @brief How the motor moves, and so where a sweep ends.
enum class SweepMotion {
  kNodding,   ///< to and fro: at each turning point
  kHalfTurn,  ///< round and round: where the tilt passes a multiple of pi
  kFullTurn   ///< round and round: where the tilt passes an odd multiple of pi
};

/// @brief Cuts a sequence of tilts into sweeps. Not thread-safe.
///
/// Nodding: a turn is recognised once the tilt has come back from its extremum by more than the hysteresis (encoder noise
/// must be smaller); the extremum is the last line of the old sweep and the lines after it belong to the new one. Spinning:
/// a line that falls back over the border by no more than the hysteresis stays in the new sweep.
class SweepSplitter {
 public:
  SweepSplitter(SweepMotion motion, double hysteresis);

  /// @brief Adds a line's tilt [rad, unwrapped] to the open sweep.
  /// @return how many of the open sweep's lines, from its first, form a completed sweep; 0 = it goes on. The others open the
  /// next.
  std::size_t feed(double tilt);

  /// @brief How many of the open sweep's lines, from its first, will form a sweep if what seems so is true; 0 = nothing
  /// does. Nodding: that the tilt has turned, as it has come back by a quarter of the hysteresis. Spinning: that the next
  /// line lies beyond the border, if it is as far from this one as this one is from the one before.
  std::size_t foreseen() const { return foreseen_; }

  /// @brief Forgets the open sweep: the next line opens a new one.
  void restart();

 private:
  std::size_t feedNodding(double tilt);
  std::size_t feedSpinning(double tilt);

  SweepMotion motion_;
  double hysteresis_;
  std::size_t lines_ = 0;  // of the open sweep
  int direction_ = 0;      // +1 up, -1 down, 0 not known yet
  double lowest_ = 0.0;    // tilts of the open sweep
  double highest_ = 0.0;
  std::size_t turn_at_ = 0;  // index of the extremum in the direction of motion
  std::size_t foreseen_ = 0;
  double sector_ = 0.0;  // spinning: number of the half or full turn
  double latest_ = 0.0;  // spinning: tilt of the line before
};

}  // namespace ppc
