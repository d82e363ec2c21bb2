// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ppc {

/// @brief Why a line is in no image.
enum class DropCause {
  kBadScan,        ///< its fields contradict each other or are not finite
  kSkipped,        ///< left out on request
  kDuplicate,      ///< a line of the same stamp came before
  kOutOfOrder,     ///< later lines were placed before it came
  kNoTilt,         ///< no tilt sample before it, or none came after it
  kTiltGap,        ///< the tilt samples around it are too far apart
  kNoTransform,    ///< tf does not know where the laser was
  kQueueFull,      ///< waited for its pose until the queue was full
  kTiltStanding,   ///< the tilt did not move
  kSweepTooSmall,  ///< its sweep had too few lines or too small a span
  kClockReset,     ///< the clock jumped back while it waited or its sweep was open
};
constexpr std::size_t kDropCauses = 11;

/// @brief The cause in words, for diagnostics.
const char* dropCauseName(DropCause cause);

/// @brief Where every line went: lines_in = lines_in_images + pending + sum of dropped.
struct LineAccounts {
  std::uint64_t lines_in = 0;
  std::uint64_t lines_in_images = 0;
  std::uint64_t pending = 0;  ///< waiting for their pose or in the open sweep
  std::array<std::uint64_t, kDropCauses> dropped{};
  std::uint64_t sweeps = 0;          ///< images made
  std::uint64_t layout_changes = 0;  ///< changes of beam count, bearings or range limits
  std::uint64_t clock_resets = 0;    ///< jumps back of the lines' clock

  std::uint64_t drops(DropCause cause) const { return dropped[static_cast<std::size_t>(cause)]; }
  std::uint64_t allDrops() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t n : dropped) sum += n;
    return sum;
  }
};

}  // namespace ppc
