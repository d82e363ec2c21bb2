// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace ppc {

int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels, std::vector<LabelRun>* runs_out) {
  const float* const ranges = grid.range.data();
  std::int32_t* const pixels = labels.labels.data();
  for (int i = 0, n = grid.size(); i < n; ++i) {  // without branches, so that it becomes vector code
    const std::int32_t label = pixels[i];
    const bool kept = (ranges[i] > 0.0F) & (label > 0);
    pixels[i] = kept ? label : 0;
  }
  std::vector<LabelRun> runs = labelRuns(labels);
  const std::int32_t highest = highestLabel(runs);
  std::vector<int> count(static_cast<std::size_t>(highest) + 1, 0);
  std::vector<int> first(count.size(), grid.size());
  for (const LabelRun& run : runs) {
    count[run.label] += run.end - run.begin;
    first[run.label] = std::min(first[run.label], run.begin);
  }
  std::vector<std::int32_t> order(static_cast<std::size_t>(highest));
  std::iota(order.begin(), order.end(), 1);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : first[a] < first[b];
  });
  std::vector<std::int32_t> renamed(count.size(), 0);
  int n = 0;
  for (const std::int32_t label : order) {
    if (count[label] >= std::max(1, min_size)) renamed[label] = ++n;
  }
  renameLabels(renamed, runs, labels);
  if (runs_out != nullptr) {
    for (LabelRun& run : runs) run.label = renamed[run.label];
    runs.erase(std::remove_if(runs.begin(), runs.end(), [](const LabelRun& run) { return run.label == 0; }), runs.end());
    *runs_out = std::move(runs);
  }
  return n;
}

}  // namespace ppc
