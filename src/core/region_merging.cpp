// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_merging.h"

#include "patch_plane_clustering/core/block_moments.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

constexpr double kWholeTolerance = 2.0;  // tolerance over a whole region over that from patch to patch
constexpr double kStepTolerance = 1.0;   // tolerance of a step along a border, likewise
constexpr double kMaxRadius = 0.5;       // of a region, for the tolerance of its angle [m]
constexpr int kBorderSteps = 2;          // depth of a border in cells
constexpr int kMinBorderPoints = 6;

using Pair = std::pair<std::int32_t, std::int32_t>;

double wholeSimilarity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                       const CoplanarityTolerance& tolerance) {
  CoplanarityTolerance whole = tolerance;
  whole.sigma_distance *= kWholeTolerance;
  const Moments& small = a.n < b.n ? a : b;
  const double range = small.mean().norm();
  const double sigma = noise.sigma(range);
  return similarity(joint.chi2 - fitPlane(a).chi2 - fitPlane(b).chi2, small.n / (sigma * sigma),
                    std::min(small.radius(), kMaxRadius), secantSquared(joint.a, range), whole);
}

double stepSimilarity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d mean_a = a.mean(), mean_b = b.mean();
  const double gap = joint.normal().dot(mean_a - mean_b);
  const double range = 0.5 * (mean_a.norm() + mean_b.norm());
  const double sigma = noise.sigma(range);
  const double variance = sigma * sigma / secantSquared(joint.a, range) * (1.0 / a.n + 1.0 / b.n) * tolerance.inflation;
  const double step = kStepTolerance * tolerance.sigma_distance;
  return std::exp(-0.5 * gap * gap / (variance + step * step));
}

// Moments of both sides of every border of a fresh label: cells within kBorderSteps of a cell in which, or next to which,
// the labels meet.
std::map<Pair, std::pair<Moments, Moments>> measureBorders(const PatchGrid& cells, const CellShares& all,
                                                           const std::vector<bool>& fresh) {
  std::map<Pair, std::vector<int>> meeting;
  const auto meet = [&](std::int32_t a, std::int32_t b, int i, int j) {
    if (a == b || !(fresh[a] || fresh[b])) return;
    auto& at = meeting[{std::min(a, b), std::max(a, b)}];
    at.push_back(i);
    at.push_back(j);
  };
  const int count = static_cast<int>(cells.patches.size());
  for (int i = 0; i < count; ++i) {
    for (int s = all.begin[i]; s < all.begin[i + 1]; ++s) {
      const std::int32_t label = all.shares[s].label;
      for (int t = s + 1; t < all.begin[i + 1]; ++t) meet(label, all.shares[t].label, i, i);
      cells.forEachNeighbour(i, [&](int j) {
        if (j < i) return;
        for (int t = all.begin[j]; t < all.begin[j + 1]; ++t) meet(label, all.shares[t].label, i, j);
      });
    }
  }
  std::map<Pair, std::pair<Moments, Moments>> borders;
  std::vector<int> reached(cells.patches.size(), -1);  // the last border that took the cell
  int border = -1;
  for (auto& [pair, near] : meeting) {
    ++border;
    std::vector<int> wave;
    const auto take = [&](int i) {
      if (reached[i] == border) return;
      reached[i] = border;
      wave.push_back(i);
    };
    for (const int i : near) take(i);
    std::size_t begin = 0;
    for (int step = 0; step < kBorderSteps; ++step) {
      const std::size_t end = wave.size();
      for (; begin < end; ++begin) cells.forEachNeighbour(wave[begin], take);
    }
    auto& [first, second] = borders[pair];
    for (const int i : wave) {
      for (int s = all.begin[i]; s < all.begin[i + 1]; ++s) {
        if (all.shares[s].label == pair.first) first += all.shares[s].moments;
        if (all.shares[s].label == pair.second) second += all.shares[s].moments;
      }
    }
  }
  return borders;
}

std::vector<Moments> sumShares(const CellShares& cells) {
  std::vector<Moments> sums(1);
  for (const CellShares::Share& share : cells.shares) {
    if (share.label >= static_cast<std::int32_t>(sums.size())) sums.resize(static_cast<std::size_t>(share.label) + 1);
    sums[share.label] += share.moments;
  }
  return sums;
}

// Renames the labels of the shares and adds up those that have become one in a cell.
void rename(const std::vector<std::int32_t>& names, CellShares& cells) {
  std::size_t out = 0;
  for (std::size_t k = 0; k + 1 < cells.begin.size(); ++k) {
    const std::size_t first = out;
    const int begin = cells.begin[k], end = cells.begin[k + 1];
    cells.begin[k] = static_cast<int>(first);
    for (int s = begin; s < end; ++s) {
      const CellShares::Share share = {names[cells.shares[s].label], cells.shares[s].moments};
      std::size_t at = first;
      while (at < out && cells.shares[at].label != share.label) ++at;
      if (at < out) {
        cells.shares[at].moments += share.moments;
      } else {
        cells.shares[out++] = share;
      }
    }
  }
  cells.begin.back() = static_cast<int>(out);
  cells.shares.resize(out);
}

}  // namespace

CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels) {
  CellShares out;
  out.begin.reserve(cells.patches.size() + 1);
  out.shares.reserve(cells.patches.size());
  const auto labelsAt = [&](int i, int count) {
    const std::int32_t* at = labels.labels.data() + i;
    const LaneMask here = i + kLanes <= grid.size() ? loadLanes<LaneMask>(at) : loadLanes<LaneMask>(at, count);
    return here & firstLanes(count);
  };
  const auto firstOf = [](LaneMask here) {
    int lane = 0;
    while (here[lane] == 0) ++lane;
    return here[lane];
  };
  std::vector<std::int32_t> found;
  for (const Patch& cell : cells.patches) {
    out.begin.push_back(static_cast<int>(out.shares.size()));
    // The usual case first: one label, whole; the patch's own sums serve.
    std::int32_t only = 0;
    LaneMask others = {}, labelled = {};
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int c = cell.col_begin; c < cell.col_end; c += kLanes) {
        const LaneMask here = labelsAt(grid.index(r, c), cell.col_end - c);
        if (only == 0 && anyLane(here)) only = firstOf(here);
        labelled += here > LaneMask{};
        others |= (here > LaneMask{}) & (here != fillMask(only));
      }
    }
    if (only == 0) continue;
    if (!anyLane(others) && countLanes(labelled) == cell.moments.n) {
      out.shares.push_back({only, cell.moments});
      continue;
    }
    found.clear();
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
        const std::int32_t label = labels.labels[i];
        if (label > 0 && std::find(found.begin(), found.end(), label) == found.end()) found.push_back(label);
      }
    }
    for (const std::int32_t label : found) {
      BlockMoments sums =
          sumBlock(grid, cells.center, cell.row_begin, cell.row_end, cell.col_begin, cell.col_end,
                   [&](int i, int count) { return labelsAt(i, count) == fillMask(label); });
      if (sums.moments.n == 0) continue;
      const double sigma = noise.sigma(sums.meanRange());
      sums.moments.scale(1.0 / (sigma * sigma));
      out.shares.push_back({label, sums.moments});
    }
  }
  out.begin.push_back(static_cast<int>(out.shares.size()));
  return out;
}

std::vector<Eigen::Vector3d> labelPlanes(const CellShares& cells) {
  std::vector<Eigen::Vector3d> planes;
  for (const Moments& m : sumShares(cells)) planes.push_back(fitPlane(m).a);
  return planes;
}

void mergeLabels(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                 CellShares& shares, LabelImage& labels) {
  std::vector<Moments> whole = sumShares(shares);
  std::vector<std::int32_t> renamed(whole.size());
  std::iota(renamed.begin(), renamed.end(), 0);
  std::vector<bool> fresh(whole.size(), true);  // pairs of labels that have not changed need no second look
  while (true) {
    std::vector<std::pair<double, Pair>> candidates;
    for (const auto& [pair, border] : measureBorders(cells, shares, fresh)) {
      if (border.first.n < kMinBorderPoints || border.second.n < kMinBorderPoints) continue;
      const Moments& a = whole[pair.first];
      const Moments& b = whole[pair.second];
      const PlaneFit joint = fitPlane(a + b);
      const double s = wholeSimilarity(a, b, joint, noise, tolerance);
      if (s < threshold || stepSimilarity(border.first, border.second, joint, noise, tolerance) < threshold) continue;
      candidates.push_back({-s, pair});
    }
    if (candidates.empty()) break;
    std::sort(candidates.begin(), candidates.end());
    std::vector<bool> changed(whole.size(), false);
    std::vector<std::int32_t> now(whole.size());
    std::iota(now.begin(), now.end(), 0);
    for (const auto& [s, pair] : candidates) {
      if (changed[pair.first] || changed[pair.second]) continue;
      changed[pair.first] = changed[pair.second] = true;
      whole[pair.first] += whole[pair.second];
      now[pair.second] = pair.first;
    }
    for (std::int32_t& label : renamed) label = now[label];
    rename(now, shares);
    fresh = changed;
  }
  for (std::int32_t& label : labels.labels) label = renamed[label];
}

}  // namespace ppc
