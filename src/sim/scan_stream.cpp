// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/scan_stream.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace ppc::sim {

ScanStream::ScanStream(const Scanner& scanner, int replay_passes)
    : scanner_(scanner), replay_lines_(replay_passes * scanner.options().motion.lines_per_pass) {
  if (replay_passes < 0 || replay_passes % 2 != 0) {
    throw std::invalid_argument("replay_passes is " + std::to_string(replay_passes) + ", allowed: even numbers from 0");
  }
}

double ScanStream::lineTime() const {
  return next_line_ * scanner_.lineDuration() + scanner_.timeIncrement() * scanner_.options().sensor.beams;
}

double ScanStream::nextTime() const { return std::min(lineTime(), next_joint_ / scanner_.options().joint_rate); }

ScanEvent ScanStream::next() {
  ScanEvent event;
  event.time = nextTime();
  event.is_line = lineTime() < next_joint_ / scanner_.options().joint_rate;
  if (!event.is_line) {
    event.joint = scanner_.joint(next_joint_++);
    return event;
  }
  if (replay_lines_ == 0) {
    event.line = scanner_.line(next_line_);
  } else {
    const int original = next_line_ % replay_lines_;
    const auto kept = kept_.find(original);
    event.line = kept != kept_.end() ? kept->second : kept_.emplace(original, scanner_.line(original)).first->second;
    event.line.index = next_line_;
    event.line.stamp = next_line_ * scanner_.lineDuration();
  }
  ++next_line_;
  return event;
}

}  // namespace ppc::sim
