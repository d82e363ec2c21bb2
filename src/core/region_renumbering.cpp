// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/run_listing.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace ppc {

namespace {

constexpr int kStretch = 4096;  // pixels whose labels are listed while they are at hand

// Clears the labels of pixels [first, last) without a measurement, and appends the runs of what is left. @return how many
// have one.
int clearUnmeasured(const BeamGrid& grid, int first, int last, LabelImage& labels, std::vector<LabelRun>& runs) {
  const float* const ranges = grid.range.data();
  std::int32_t* const pixels = labels.labels.data();
  int valid_points = 0;
  for (int begin = first; begin < last; begin += kStretch) {
    const int end = std::min(begin + kStretch, last);
    for (int i = begin; i < end; ++i) {  // without branches, so that it becomes vector code
      const std::int32_t label = pixels[i];
      const bool valid = ranges[i] > 0.0F, kept = valid & (label > 0);
      valid_points += valid;
      pixels[i] = kept ? label : 0;
    }
    for (int at = begin, run_end = 0; at < end; at = run_end) {
      run_end = runEnd(pixels, at, end);
      if (pixels[at] > 0) appendRun({pixels[at], at, run_end}, runs);
    }
  }
  return valid_points;
}

// The same of the whole image.
int clearUnmeasured(const BeamGrid& grid, RenumberingMemory& memory, LabelImage& labels, std::vector<LabelRun>& runs,
                    int threads) {
  memory.valid.resize(static_cast<std::size_t>(rangeCount(threads, grid.size())));
  gatherRuns(threads, grid.size(), memory.listing, runs, [&](int part, int begin, int end, std::vector<LabelRun>& out) {
    memory.valid[part] = clearUnmeasured(grid, begin, end, labels, out);
  });
  return std::accumulate(memory.valid.begin(), memory.valid.end(), 0);
}

}  // namespace

int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels) {
  RenumberingMemory memory;
  std::vector<LabelRun> runs;
  int valid_points = 0;
  return renumberBySize(grid, min_size, memory, labels, runs, valid_points);
}

int renumberBySize(const BeamGrid& grid, int min_size, RenumberingMemory& memory, LabelImage& labels,
                   std::vector<LabelRun>& runs, int& valid_points, int threads) {
  valid_points = clearUnmeasured(grid, memory, labels, runs, threads);
  const auto highest = static_cast<std::size_t>(highestLabel(runs));
  std::vector<int>&count = memory.count, &first = memory.first;
  count.assign(highest + 1, 0);
  first.assign(highest + 1, grid.size());
  for (const LabelRun& run : runs) {
    count[run.label] += run.end - run.begin;
    first[run.label] = std::min(first[run.label], run.begin);
  }
  std::vector<std::int32_t>& order = memory.order;
  order.resize(highest);
  std::iota(order.begin(), order.end(), 1);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : first[a] < first[b];
  });
  std::vector<std::int32_t>& renamed = memory.renamed;
  renamed.assign(highest + 1, 0);
  int n = 0;
  for (const std::int32_t label : order) {
    if (count[label] >= std::max(1, min_size)) renamed[label] = ++n;
  }
  forEachRange(threads, static_cast<int>(runs.size()),
               [&](int begin, int end) { renameLabels(renamed, runs.data() + begin, runs.data() + end, labels); });
  for (LabelRun& run : runs) run.label = renamed[run.label];
  runs.erase(std::remove_if(runs.begin(), runs.end(), [](const LabelRun& run) { return run.label == 0; }), runs.end());
  return n;
}

}  // namespace ppc
