// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace ppc {

/// How many labels are compared at a time.
constexpr int kLabelStep = 4 * kLanes;

/// One bit a label, the first one lowest, of kLabelStep labels: whether `differ` says so of it. @param differ differ(k): of
/// labels k to k + kLanes, lane by lane.
template <typename F>
std::uint32_t labelBits(const F& differ) {
  const LaneMask bits{1, 2, 4, 8};
  const LaneMask found = ((differ(0) & bits) | (differ(kLanes) & (bits << 4))) |
                         ((differ(2 * kLanes) & (bits << 8)) | (differ(3 * kLanes) & (bits << 12)));
  std::uint64_t halves[2];
  std::memcpy(halves, &found, sizeof halves);
  const std::uint64_t both = halves[0] | halves[1];
  return static_cast<std::uint32_t>(both | both >> 32U);
}

/// End of the stretch of equal labels that begins at `begin`, `limit` at most.
inline int runEnd(const std::int32_t* labels, int begin, int limit) {
  const LaneMask label = fillMask(labels[begin]);
  int end = begin + 1;
  for (; end + kLabelStep <= limit; end += kLabelStep) {
    const std::uint32_t others = labelBits([&](int k) { return loadLanes<LaneMask>(labels + end + k) != label; });
    if (others != 0) return end + __builtin_ctz(others);
  }
  for (; end + kLanes <= limit; end += kLanes) {
    if (anyLane(loadLanes<LaneMask>(labels + end) != label)) break;
  }
  while (end < limit && labels[end] == labels[begin]) ++end;
  return end;
}

/// Calls f(label, begin, end) for every stretch of pixels of one label above 0, in scan order. A stretch may go on over the
/// ends of rows.
template <typename F>
void forEachRun(const LabelImage& labels, F&& f) {
  const int n = static_cast<int>(labels.labels.size());
  for (int begin = 0, end = 0; begin < n; begin = end) {
    end = runEnd(labels.labels.data(), begin, n);
    if (labels.labels[begin] > 0) f(labels.labels[begin], begin, end);
  }
}

/// Four labels from pixel i on; those beyond the image are 0.
inline LaneMask labelsAt(const LabelImage& labels, int i, int count) {
  const std::int32_t* at = labels.labels.data() + i;
  const bool inside = i + kLanes <= static_cast<int>(labels.labels.size());
  return inside ? loadLanes<LaneMask>(at) : loadLanes<LaneMask>(at, count);
}

/// Calls f(pixel) for every pixel of row `r` above 0 whose label differs from that of the pixel above it.
template <typename F>
void forEachChangeFromAbove(const LabelImage& labels, int r, F&& f) {
  const std::int32_t* const row = labels.labels.data() + static_cast<std::size_t>(r) * labels.cols;
  const std::int32_t* const above = row - labels.cols;
  int c = 0;
  for (; c + kLabelStep <= labels.cols; c += kLabelStep) {
    std::uint32_t others =
        labelBits([&](int k) { return loadLanes<LaneMask>(row + c + k) != loadLanes<LaneMask>(above + c + k); });
    for (; others != 0; others &= others - 1) f(r * labels.cols + c + __builtin_ctz(others));
  }
  for (; c < labels.cols; ++c) {
    if (row[c] != above[c]) f(r * labels.cols + c);
  }
}

/// Calls f(pixel, step, place) for every pixel whose label differs from that of the pixel before it: in its row (step 1),
/// and in its column (step: the number of columns). `place` is the pixel's column or row. Row by row, along rows first.
template <typename F>
void forEachChange(const LabelImage& labels, F&& f) {
  const std::int32_t* const pixels = labels.labels.data();
  for (int r = 0; r < labels.rows; ++r) {
    const int row = r * labels.cols;
    for (int c = 0; c < labels.cols; c = runEnd(pixels + row, c, labels.cols)) {
      if (c > 0) f(row + c, 1, c);
    }
    if (r > 0) forEachChangeFromAbove(labels, r, [&](int pixel) { f(pixel, labels.cols, r); });
  }
}

/// A stretch of pixels of one label above 0.
struct LabelRun {
  std::int32_t label;
  int begin, end;
};

/// Lists the stretches of forEachRun(): for what looks at them more than once. @param runs overwritten.
inline void listRuns(const LabelImage& labels, std::vector<LabelRun>& runs) {
  runs.clear();
  forEachRun(labels, [&](std::int32_t label, int begin, int end) { runs.push_back({label, begin, end}); });
}
inline std::vector<LabelRun> labelRuns(const LabelImage& labels) {
  std::vector<LabelRun> runs;
  listRuns(labels, runs);
  return runs;
}

/// The largest label of runs; 0 if there is none.
inline std::int32_t highestLabel(const std::vector<LabelRun>& runs) {
  std::int32_t highest = 0;
  for (const LabelRun& run : runs) highest = std::max(highest, run.label);
  return highest;
}

/// Counts the pixels of every label. @param labels count of labels. @param points index = label.
inline void countPoints(const std::vector<LabelRun>& runs, std::size_t labels, std::vector<int>& points) {
  points.assign(labels, 0);
  for (const LabelRun& run : runs) points[run.label] += run.end - run.begin;
}

/// Replaces the labels of runs [begin, end) by names[label].
inline void renameLabels(const std::vector<std::int32_t>& names, const LabelRun* begin, const LabelRun* end,
                         LabelImage& labels) {
  for (const LabelRun* run = begin; run != end; ++run) {
    if (names[run->label] == run->label) continue;
    std::fill(labels.labels.begin() + run->begin, labels.labels.begin() + run->end, names[run->label]);
  }
}

/// Replaces every label above 0 by names[label]. @param runs those of the image, before.
inline void renameLabels(const std::vector<std::int32_t>& names, const std::vector<LabelRun>& runs, LabelImage& labels) {
  renameLabels(names, runs.data(), runs.data() + runs.size(), labels);
}

/// Gives every pixel of the runs the name of its run's label, whatever it had.
inline void paintRuns(const std::vector<LabelRun>& runs, const std::vector<std::int32_t>& names, LabelImage& labels) {
  std::int32_t* const pixels = labels.labels.data();
  for (const LabelRun& run : runs) std::fill(pixels + run.begin, pixels + run.end, names[run.label]);
}

/// Gives every pixel of the runs its run's label.
inline void paintRuns(const std::vector<LabelRun>& runs, LabelImage& labels) {
  std::int32_t* const pixels = labels.labels.data();
  for (const LabelRun& run : runs) std::fill(pixels + run.begin, pixels + run.end, run.label);
}

/// Appends a run, or lengthens the last one if that ends there and has the same label.
inline void appendRun(const LabelRun& run, std::vector<LabelRun>& runs) {
  if (!runs.empty() && runs.back().end == run.begin && runs.back().label == run.label) {
    runs.back().end = run.end;
  } else {
    runs.push_back(run);
  }
}

/// Appends runs that lie behind those that are there, of which the last one may go on over the seam.
inline void appendRuns(const std::vector<LabelRun>& more, std::vector<LabelRun>& runs) {
  if (more.empty()) return;
  appendRun(more.front(), runs);
  runs.insert(runs.end(), more.begin() + 1, more.end());
}

/// Gives runs the names of their labels, all above 0, and joins those that come to follow one another.
inline void renameRuns(const std::vector<std::int32_t>& names, std::vector<LabelRun>& runs) {
  std::size_t kept = 0;
  for (const LabelRun& run : runs) {
    const LabelRun renamed{names[run.label], run.begin, run.end};
    if (kept > 0 && runs[kept - 1].end == renamed.begin && runs[kept - 1].label == renamed.label) {
      runs[kept - 1].end = renamed.end;
    } else {
      runs[kept++] = renamed;
    }
  }
  runs.resize(kept);
}

/// Counts the points of every label, and finds those that are no region: 0, and what has fewer than `smallest`.
/// @param labels count of labels. @param points, loose set; index = label.
inline void findLoose(const std::vector<LabelRun>& runs, std::size_t labels, int smallest, std::vector<int>& points,
                      std::vector<char>& loose) {
  countPoints(runs, labels, points);
  loose.resize(labels);
  for (std::size_t label = 0; label < labels; ++label) loose[label] = label == 0 || points[label] < smallest ? 1 : 0;
}

/// The largest label of an image; 0 if there is none.
inline std::int32_t highestLabel(const LabelImage& labels) {
  std::int32_t highest = 0;
  for (const std::int32_t label : labels.labels) highest = std::max(highest, label);
  return highest;
}

}  // namespace ppc
