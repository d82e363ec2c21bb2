// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_accounts.h"

namespace ppc {

const char* dropCauseName(DropCause cause) {
  switch (cause) {
    case DropCause::kBadScan:
      return "bad scan";
    case DropCause::kSkipped:
      return "skipped on request";
    case DropCause::kDuplicate:
      return "duplicate stamp";
    case DropCause::kOutOfOrder:
      return "out of order";
    case DropCause::kNoTilt:
      return "no tilt";
    case DropCause::kTiltGap:
      return "tilt gap";
    case DropCause::kNoTransform:
      return "no transform";
    case DropCause::kQueueFull:
      return "queue full";
    case DropCause::kTiltStanding:
      return "tilt standing";
    case DropCause::kSweepTooSmall:
      return "sweep too small";
    case DropCause::kClockReset:
      return "clock reset";
  }
  return "unknown";
}

}  // namespace ppc
