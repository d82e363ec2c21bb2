// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/part_lists.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of gatherRuns(), which one image after the other may use: runs of each part but the first one.
struct RunListMemory {
  std::vector<std::vector<LabelRun>> rest;
};

/// @brief Gathers runs that are listed in parts, on several threads. @param count things that are listed, in rangeCount()
/// parts. @param list list(part, begin, end, runs): appends those of things [begin, end); called as by forEachPart().
/// @param runs overwritten; in the order of the parts, those that go on over a seam joined (appendRuns()).
template <typename F>
void gatherRuns(int threads, int count, RunListMemory& memory, std::vector<LabelRun>& runs, F&& list) {
  const int parts = listInParts(threads, count, runs, memory.rest, [&](int part, int begin, int end, auto& out) {
    out.clear();
    list(part, begin, end, out);
  });
  for (int part = 1; part < parts; ++part) appendRuns(memory.rest[part - 1], runs);
}

/// listRuns() on several threads.
inline void listRuns(const LabelImage& labels, RunListMemory& memory, std::vector<LabelRun>& runs, int threads) {
  gatherRuns(threads, static_cast<int>(labels.labels.size()), memory, runs,
             [&](int, int first, int last, std::vector<LabelRun>& out) {
               const std::int32_t* const pixels = labels.labels.data();
               for (int begin = first, end = 0; begin < last; begin = end) {
                 end = runEnd(pixels, begin, last);
                 if (pixels[begin] > 0) out.push_back({pixels[begin], begin, end});
               }
             });
}

/// @brief Gives every pixel the name of its label, and lists the runs of these names.
/// @param names index = label; that of 0 is 0.
inline void renameAndList(const std::vector<std::int32_t>& names, LabelImage& labels, RunListMemory& memory,
                          std::vector<LabelRun>& runs, int threads) {
  gatherRuns(threads, static_cast<int>(labels.labels.size()), memory, runs,
             [&](int, int first, int last, std::vector<LabelRun>& out) {
               std::int32_t* const pixels = labels.labels.data();
               for (int begin = first, end = 0; begin < last; begin = end) {
                 end = runEnd(pixels, begin, last);
                 if (pixels[begin] <= 0) continue;
                 const std::int32_t name = names[pixels[begin]];
                 if (name != pixels[begin]) std::fill(pixels + begin, pixels + end, name);
                 if (name > 0) appendRun({name, begin, end}, out);
               }
             });
}

}  // namespace ppc
