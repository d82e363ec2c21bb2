// SPDX-License-Identifier: BSD-3-Clause
#include "measure.h"

#include "affinity.h"
#include "allocations.h"
#include "patch_plane_clustering/core/quantile.h"

#include <time.h>
#include <algorithm>
#include <cstdio>
#include <utility>

namespace ppc::bench {
namespace {

double seconds(Clock clock) {
  timespec now{};
  clock_gettime(clock == Clock::kProcessor ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void run(benchmark::State& state, int points, Clock clock, const std::function<Frame()>& prepare) {
  if (clock == Clock::kProcessor) {
    if (pinToOneProcessor() < 0) std::fprintf(stderr, "not pinned to one processor\n");
  } else {
    unpin();
  }
  const Frame frame = prepare();
  std::vector<StageTime> stages;
  frame(stages);
  stages.clear();
  const Memory memory = memoryOf([&] { frame(stages); });

  std::vector<double> times;
  std::vector<std::pair<std::string, std::vector<double>>> stage_times;
  for ([[maybe_unused]] auto _ : state) {
    stages.clear();
    const double start = seconds(clock);
    frame(stages);
    const double taken = seconds(clock) - start;
    state.SetIterationTime(taken);
    times.push_back(1e3 * taken);
    for (std::size_t i = 0; i < stages.size(); ++i) {
      if (i == stage_times.size()) stage_times.emplace_back(stages[i].first, std::vector<double>());
      stage_times[i].second.push_back(stages[i].second);
    }
  }
  state.counters["median_ms"] = median(times);
  state.counters["fastest_ms"] = *std::min_element(times.begin(), times.end());
  state.counters["points"] = points;
  state.counters["allocations"] = static_cast<double>(memory.allocations);
  state.counters["allocated_bytes"] = static_cast<double>(memory.bytes);
  state.counters["peak_bytes"] = static_cast<double>(memory.peak);
  for (std::size_t i = 0; i < stage_times.size(); ++i) {
    auto& [stage, milliseconds] = stage_times[i];
    const std::string name = std::to_string(100 + i) + " " + stage;  // counters are kept by name: the number keeps the order
    state.counters["stage:" + name] = median(milliseconds);
    state.counters["fastest:" + name] = *std::min_element(milliseconds.begin(), milliseconds.end());
  }
}

}  // namespace

void addBenchmark(const std::string& name, int points, const Effort& effort, std::function<Frame()> prepare) {
  auto* const added =
      benchmark::RegisterBenchmark(name.c_str(), [points, clock = effort.clock, prepare = std::move(prepare)](
                                                     benchmark::State& state) { run(state, points, clock, prepare); });
  added->UseManualTime()->Unit(benchmark::kMillisecond);
  if (effort.frames > 0) {
    added->Iterations(effort.frames);
  } else {
    added->MinTime(effort.seconds);
  }
}

}  // namespace ppc::bench
