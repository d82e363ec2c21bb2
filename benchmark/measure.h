// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <benchmark/benchmark.h>
#include <functional>
#include <string>
#include <vector>

namespace ppc::bench {

/// One frame of work; appends the times of its stages, if it knows them.
using Frame = std::function<void(std::vector<StageTime>& stages)>;

/// What counts as the time of a frame.
enum class Clock {
  kProcessor,  ///< that of the process, pinned to one processor: other programs on the machine disturb it little
  kWall        ///< what passes, on all processors: for several threads, with nothing else running
};

/// @brief How often a benchmark runs: for `seconds`, or `frames` times if that is not 0.
struct Effort {
  double seconds = 1.0;
  int frames = 0;
  Clock clock = Clock::kProcessor;
};

/// @brief Registers a benchmark. `prepare` is called once, outside the measurement, and returns the frame.
///
/// After a frame that warms up and one whose memory is counted, each frame is timed alone. Counters: `median_ms`,
/// `fastest_ms`, `points`, `allocations`, `allocated_bytes`, `peak_bytes`, `stage:NAME` with the median and `fastest:NAME`
/// with the shortest time of each stage [ms], by the pipeline's own clock.
void addBenchmark(const std::string& name, int points, const Effort& effort, std::function<Frame()> prepare);

}  // namespace ppc::bench
