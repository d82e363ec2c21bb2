// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/border_settlement.h"

#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/refinement.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

// Points that a new piece has kept of a piece before.
struct Kept {
  std::int32_t piece, before;
  int points;
};

// Calls f(label, was, begin, end) for every stretch of pixels of one run and of one piece before, or none (0).
template <typename F>
void forEachStretch(const LabelPieces& before, const std::vector<LabelRun>& runs, F&& f) {
  const LabelRun* was = before.runs.data();
  const LabelRun* const last = was + before.runs.size();
  for (const LabelRun& run : runs) {
    for (int begin = run.begin, end = 0; begin < run.end; begin = end) {
      while (was != last && was->end <= begin) ++was;
      const bool inside = was != last && was->begin <= begin;
      end = was == last ? run.end : std::min(run.end, inside ? was->end : was->begin);
      f(run.label, inside ? was->label : 0, begin, end);
    }
  }
}

// What the new pieces have kept, by piece and piece before.
std::vector<Kept> countKept(const LabelPieces& before, const std::vector<LabelRun>& runs,
                            const std::vector<std::int32_t>& whole) {
  std::vector<Kept> kept;
  std::vector<std::size_t> latest(whole.size(), 0);  // of each new piece, plus one: most stretches add to it
  forEachStretch(before, runs, [&](std::int32_t piece, std::int32_t was, int begin, int end) {
    if (was == 0 || before.whole[was] != whole[piece]) return;
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
  return kept;
}

// Whether each piece before is, or is part of, a region that is large enough.
std::vector<char> findRegions(const LabelPieces& before, int smallest) {
  std::vector<int> points(before.names.size(), 0);
  for (const LabelRun& run : before.runs) points[before.names[run.label]] += run.end - run.begin;
  std::vector<char> is_region(before.names.size(), 0);
  for (std::size_t piece = 1; piece < is_region.size(); ++piece) {
    const std::int32_t name = before.names[piece];
    is_region[piece] = name != 0 && points[name] >= smallest ? 1 : 0;
  }
  return is_region;
}

// For every piece of one kind, the one of the other kind that it shares most points with; 0 if there is none.
std::vector<std::int32_t> mostOf(const std::vector<Kept>& kept, std::int32_t Kept::*of, std::int32_t Kept::*other,
                                 std::size_t count) {
  std::vector<std::int32_t> found(count, 0);
  std::vector<int> points(count, 0);
  for (const Kept& k : kept) {
    if (k.points <= points[k.*of]) continue;
    points[k.*of] = k.points;
    found[k.*of] = k.*other;
  }
  return found;
}

// Runs of the labels after the contest; but points of regions that went to a label without any region are given back to
// theirs: such a label may only defend its own.
std::vector<LabelRun> settledRuns(const LabelImage& labels, const LabelPieces& before, const std::vector<char>& is_region,
                                  std::size_t count) {
  std::vector<char> has_region(count, 0);  // of each label
  for (std::size_t piece = 1; piece < is_region.size(); ++piece) {
    if (is_region[piece] != 0) has_region[before.whole[piece]] = 1;
  }
  const std::vector<LabelRun> contested = labelRuns(labels);
  std::vector<LabelRun> runs;
  runs.reserve(contested.size());
  forEachStretch(before, contested, [&](std::int32_t label, std::int32_t was, int begin, int end) {
    appendRun({is_region[was] > has_region[label] ? before.whole[was] : label, begin, end}, runs);
  });
  return runs;
}

// Names of the new pieces: themselves, 0 for those that are no regions, or that of the region which they are given to.
std::vector<std::int32_t> nameRegions(const LabelPieces& before, const std::vector<char>& is_region,
                                      const std::vector<Kept>& kept, const std::vector<std::int32_t>& heir,
                                      std::size_t count) {
  std::vector<int> balance(count, 0);
  for (const Kept& k : kept) balance[k.piece] += is_region[k.before] != 0 ? k.points : -k.points;
  const std::vector<std::int32_t> origin = mostOf(kept, &Kept::piece, &Kept::before, count);  // of each
  std::vector<std::int32_t> names(count, 0);
  for (std::size_t piece = 1; piece < count; ++piece) {
    if (balance[piece] > 0) names[piece] = static_cast<std::int32_t>(piece);
  }
  for (std::size_t piece = 1; piece < count; ++piece) {
    if (names[piece] == 0) continue;
    const std::int32_t name = before.names[origin[piece]];
    if (name != 0 && name != origin[piece] && names[heir[name]] != 0) names[piece] = names[heir[name]];
  }
  return names;
}

// Writes names, but what kept its label stays what it was: points of a region are not lost to what is none, and those of no
// region do not come back with a region that has reached them.
void writeNames(const LabelPieces& before, const std::vector<char>& is_region, const std::vector<std::int32_t>& heir,
                const std::vector<std::int32_t>& whole, const std::vector<std::int32_t>& names,
                const std::vector<LabelRun>& runs, LabelImage& labels) {
  forEachStretch(before, runs, [&](std::int32_t piece, std::int32_t was, int begin, int end) {
    std::int32_t name = names[piece];
    if (is_region[was] != 0) {
      const std::int32_t home = heir[before.names[was]];
      if (name == 0) name = names[home] != 0 ? names[home] : home;
    } else if (was != 0 && before.whole[was] == whole[piece]) {
      name = 0;
    }
    std::fill(labels.labels.begin() + begin, labels.labels.begin() + end, name);
  });
}

}  // namespace

std::vector<std::int32_t> settleBorders(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                                        const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                                        const CoplanarityTolerance& tolerance, const LabelPieces& before, int smallest,
                                        int gap_rows, int gap_cols, LabelImage& labels, int threads) {
  contestLabels(grid, cells, shares, planes, noise, tolerance, labels, threads);
  const std::vector<char> is_region = findRegions(before, smallest);
  std::vector<LabelRun> runs = settledRuns(labels, before, is_region, planes.size());
  std::vector<std::int32_t> whole = splitRuns(grid.cols, gap_rows, gap_cols, runs);
  const std::vector<Kept> kept = countKept(before, runs, whole);
  const std::vector<std::int32_t> heir = mostOf(kept, &Kept::before, &Kept::piece, before.names.size());
  const std::vector<std::int32_t> names = nameRegions(before, is_region, kept, heir, whole.size());
  writeNames(before, is_region, heir, whole, names, runs, labels);
  return whole;
}

}  // namespace ppc
