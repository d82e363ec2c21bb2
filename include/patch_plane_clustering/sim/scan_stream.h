// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/sim/scanner.h"

#include <map>

namespace ppc::sim {

/// @brief What the hardware says at one moment: a joint sample, or else a line that has just been completed.
struct ScanEvent {
  double time = 0.0;  ///< since the start [s]: a sample's own stamp, or the moment after a line's last beam
  bool is_line = false;
  JointSample joint;
  ScanLine line;
};

/// @brief Joint samples and lines of a scanner in the order of time, without end. Not thread-safe.
class ScanStream {
 public:
  /// @param scanner must outlive the stream.
  /// @param replay_passes 0: every line is rendered when it is due, with errors of its own. n > 0: lines of the first n
  /// passes are
  ///        kept and come again with later stamps, which costs next to nothing. After 2 passes every motion is where it was,
  ///        so n must be even. @throws std::invalid_argument if it is not, or negative.
  ScanStream(const Scanner& scanner, int replay_passes);

  /// Time of the event that next() will give [s].
  double nextTime() const;

  ScanEvent next();

 private:
  double lineTime() const;

  const Scanner& scanner_;
  int replay_lines_;
  int next_line_ = 0;
  int next_joint_ = 0;
  std::map<int, ScanLine> kept_;
};

}  // namespace ppc::sim
