// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/border_settlement.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr double kMostTaken = 0.4;  // points of a region taken from what bends, over those kept, less those kept of none

using Kept = BorderMemory::Kept;

// Calls f(label, was, begin, end) for every stretch of pixels of one run and of one piece before, or none (0).
template <typename F>
void forEachStretch(const LabelPieces& before, const LabelRun* runs, const LabelRun* runs_end, F&& f) {
  const LabelRun* was = before.runs.data();
  const LabelRun* const last = was + before.runs.size();
  if (runs == runs_end) return;
  was = std::partition_point(was, last, [&](const LabelRun& run) { return run.end <= runs->begin; });
  for (; runs != runs_end; ++runs) {
    const LabelRun& run = *runs;
    for (int begin = run.begin, end = 0; begin < run.end; begin = end) {
      while (was != last && was->end <= begin) ++was;
      const bool inside = was != last && was->begin <= begin;
      end = was == last ? run.end : std::min(run.end, inside ? was->end : was->begin);
      f(run.label, inside ? was->label : 0, begin, end);
    }
  }
}

template <typename F>
void forEachStretch(const LabelPieces& before, const std::vector<LabelRun>& runs, F&& f) {
  forEachStretch(before, runs.data(), runs.data() + runs.size(), f);
}

// What the new pieces have kept, by piece and piece before, and what they have taken from pieces that bend.
void countKept(const LabelPieces& before, const std::vector<std::int32_t>& whole, BorderMemory& memory) {
  std::vector<Kept>& kept = memory.kept;
  std::vector<std::size_t>& latest = memory.latest;  // most stretches add to it
  kept.clear();
  latest.assign(whole.size(), 0);
  memory.taken.assign(whole.size(), 0);
  forEachStretch(before, memory.runs, [&](std::int32_t piece, std::int32_t was, int begin, int end) {
    if (was == 0) return;
    if (before.whole[was] != whole[piece]) {
      if (before.names[was] == 0) memory.taken[piece] += end - begin;
      return;
    }
    if (latest[piece] == 0 || kept[latest[piece] - 1].before != was) {
      kept.push_back({piece, was, 0});
      latest[piece] = kept.size();
    }
    kept[latest[piece] - 1].points += end - begin;
  });
  std::sort(kept.begin(), kept.end(),
            [](const Kept& a, const Kept& b) { return a.piece != b.piece ? a.piece < b.piece : a.before < b.before; });
  std::size_t size = 0;
  for (const Kept& next : kept) {
    if (size > 0 && kept[size - 1].piece == next.piece && kept[size - 1].before == next.before) {
      kept[size - 1].points += next.points;
    } else {
      kept[size++] = next;
    }
  }
  kept.resize(size);
}

void findRegions(const LabelPieces& before, int smallest, BorderMemory& memory) {
  std::vector<int>& points = memory.points;
  std::vector<char>& is_region = memory.is_region;
  points.assign(before.names.size(), 0);
  is_region.assign(before.names.size(), 0);
  for (const LabelRun& run : before.runs) points[before.names[run.label]] += run.end - run.begin;
  for (std::size_t piece = 1; piece < is_region.size(); ++piece) {
    const std::int32_t name = before.names[piece];
    is_region[piece] = name != 0 && points[name] >= smallest ? 1 : 0;
  }
}

// For every piece of one kind, the one of the other kind that it shares most points with; 0 if there is none.
// @param points scratch.
void findMostOf(const std::vector<Kept>& kept, std::int32_t Kept::*of, std::int32_t Kept::*other, std::size_t count,
                std::vector<int>& points, std::vector<std::int32_t>& found) {
  found.assign(count, 0);
  points.assign(count, 0);
  for (const Kept& k : kept) {
    if (k.points <= points[k.*of]) continue;
    points[k.*of] = k.points;
    found[k.*of] = k.*other;
  }
}

// Runs of the labels after the contest; but points of regions that went to a label without any region are given back to
// theirs: such a label may only defend its own. @param count of labels.
void settleRuns(const LabelPieces& before, std::size_t count, BorderMemory& memory) {
  const std::vector<char>& is_region = memory.is_region;
  std::vector<char>& has_region = memory.has_region;
  has_region.assign(count, 0);
  for (std::size_t piece = 1; piece < is_region.size(); ++piece) {
    if (is_region[piece] != 0) has_region[before.whole[piece]] = 1;
  }
  memory.runs.clear();
  memory.runs.reserve(memory.contested.size());
  forEachStretch(before, memory.contested, [&](std::int32_t label, std::int32_t was, int begin, int end) {
    appendRun({is_region[was] > has_region[label] ? before.whole[was] : label, begin, end}, memory.runs);
  });
}

// Names of the new pieces: themselves, 0 for those that are no regions, or that of the region which they are given to.
void nameRegions(const LabelPieces& before, std::size_t count, BorderMemory& memory) {
  const std::vector<std::int32_t>&heir = memory.heir, &origin = memory.origin;
  std::vector<std::int32_t>& names = memory.names;
  std::vector<int>& balance = memory.points;
  balance.assign(count, 0);
  for (const Kept& k : memory.kept) balance[k.piece] += memory.is_region[k.before] != 0 ? k.points : -k.points;
  names.assign(count, 0);
  memory.bends.assign(count, 0);
  for (std::size_t piece = 1; piece < count; ++piece) {
    if (balance[piece] <= 0) continue;
    const bool bends = memory.taken[piece] > kMostTaken * balance[piece];
    memory.bends[piece] = bends ? 1 : 0;
    names[piece] = bends ? 0 : static_cast<std::int32_t>(piece);
  }
  memory.own = names;
  for (std::size_t piece = 1; piece < count; ++piece) {
    if (names[piece] == 0) continue;
    const std::int32_t name = before.names[origin[piece]];
    if (name == 0 || name == origin[piece]) continue;
    const std::int32_t host = heir[name];
    if (memory.own[host] != 0 || memory.bends[host] != 0) names[piece] = memory.own[host];
  }
}

// Writes names, but what kept its label stays what it was, unless its piece bends: points of a region are not lost to what
// is none, and those of no region do not come back with a region that has reached them. Lists their runs on the way.
void writeNames(const LabelPieces& before, const std::vector<std::int32_t>& whole, BorderMemory& memory, LabelImage& labels,
                int threads) {
  const std::vector<std::int32_t>&names = memory.names, &heir = memory.heir;
  const LabelRun* const runs = memory.runs.data();
  const auto nameOf = [&](std::int32_t piece, std::int32_t was) {
    const std::int32_t name = names[piece];
    if (memory.bends[piece] != 0 && before.whole[was] == whole[piece]) return std::int32_t{0};
    if (memory.is_region[was] != 0) {
      const std::int32_t home = heir[before.names[was]];
      return name != 0 ? name : names[home] != 0 ? names[home] : memory.bends[home] != 0 ? 0 : home;
    }
    return was != 0 && before.whole[was] == whole[piece] ? 0 : name;
  };
  const auto write_all = [&](int, int first, int last, std::vector<LabelRun>& settled) {
    const auto write = [&](std::int32_t piece, std::int32_t was, int begin, int end) {
      const std::int32_t name = nameOf(piece, was);
      std::fill(labels.labels.begin() + begin, labels.labels.begin() + end, name);
      if (name != 0) appendRun({name, begin, end}, settled);
    };
    forEachStretch(before, runs + first, runs + last, write);
  };
  gatherRuns(threads, static_cast<int>(memory.runs.size()), memory.listing, memory.settled, write_all);
}

}  // namespace

void settleBorders(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, const LabelPieces& before, int smallest, int gap_rows,
                   int gap_cols, BorderMemory& memory, LabelImage& labels, std::vector<std::int32_t>& whole, int threads) {
  contestLabels(grid, cells, shares, planes, noise, tolerance, memory.contest, labels, threads);
  listRuns(labels, memory.contested);
  settleContested(grid.cols, before, planes.size(), smallest, gap_rows, gap_cols, memory, labels, whole, threads);
}

void settleContested(int cols, const LabelPieces& before, std::size_t count, int smallest, int gap_rows, int gap_cols,
                     BorderMemory& memory, LabelImage& labels, std::vector<std::int32_t>& whole, int threads) {
  findRegions(before, smallest, memory);
  settleRuns(before, count, memory);
  splitRuns(cols, gap_rows, gap_cols, memory.split, memory.runs, whole);
  countKept(before, whole, memory);
  findMostOf(memory.kept, &Kept::before, &Kept::piece, before.names.size(), memory.points, memory.heir);
  findMostOf(memory.kept, &Kept::piece, &Kept::before, whole.size(), memory.points, memory.origin);
  nameRegions(before, whole.size(), memory);
  writeNames(before, whole, memory, labels, threads);
}

}  // namespace ppc
