// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_merging.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace patch_plane_clustering {
namespace {

constexpr double kWholeTolerance = 2.0;  // tolerance over a whole region over that from patch to patch
constexpr double kStepTolerance = 1.0;  // tolerance of a step along a border, likewise
constexpr double kMaxRadius = 0.5;       // of a region, for the tolerance of its angle [m]
constexpr int kBorderSteps = 2;          // depth of a border in cells
constexpr int kMinBorderPoints = 6;

using Pair = std::pair<std::int32_t, std::int32_t>;

struct CellShare {
  std::int32_t label;
  Moments moments;
};

// The labels in every cell, with their moments.
std::vector<std::vector<CellShare>> shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                                               const LabelImage& labels) {
  std::vector<std::vector<CellShare>> shares(cells.patches.size());
  for (std::size_t k = 0; k < cells.patches.size(); ++k) {
    const Patch& cell = cells.patches[k];
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int c = cell.col_begin; c < cell.col_end; ++c) {
        const int i = grid.index(r, c);
        const std::int32_t label = labels.labels[i];
        if (label == 0 || !grid.valid(i)) continue;
        auto share = std::find_if(shares[k].begin(), shares[k].end(), [&](const auto& s) { return s.label == label; });
        if (share == shares[k].end()) share = shares[k].insert(share, {label, Moments()});
        const Eigen::Vector3d p = grid.point(i).cast<double>() - cells.center;
        const double precision = grid.range[i] / noise.sigma(grid.range[i]);
        share->moments.add(p.x(), p.y(), p.z(), precision * precision);
      }
    }
  }
  return shares;
}

double radius(const Moments& m) {
  return std::sqrt(std::max(0.0, (m.xx + m.yy + m.zz) / m.w - m.mean().squaredNorm()));
}

double wholeSimilarity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                       const CoplanarityTolerance& tolerance) {
  CoplanarityTolerance whole = tolerance;
  whole.sigma_distance *= kWholeTolerance;
  const Moments& small = a.n < b.n ? a : b;
  const double range = small.mean().norm();
  const double sigma = noise.sigma(range);
  return similarity(joint.chi2 - fitPlane(a).chi2 - fitPlane(b).chi2, small.n / (sigma * sigma),
                    std::min(radius(small), kMaxRadius), secantSquared(joint.a, range), whole);
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

// Moments of both sides of every border: cells within kBorderSteps of a cell in which, or next to which, the labels meet.
std::map<Pair, std::pair<Moments, Moments>> measureBorders(const PatchGrid& cells,
                                                           const std::vector<std::vector<CellShare>>& shares) {
  std::map<Pair, std::vector<int>> meeting;
  const auto meet = [&](std::int32_t a, std::int32_t b, int i, int j) {
    if (a == b) return;
    auto& at = meeting[{std::min(a, b), std::max(a, b)}];
    at.push_back(i);
    at.push_back(j);
  };
  for (int i = 0; i < static_cast<int>(shares.size()); ++i) {
    for (const CellShare& s : shares[i]) {
      for (const CellShare& t : shares[i]) {
        if (s.label < t.label) meet(s.label, t.label, i, i);
      }
      cells.forEachNeighbour(i, [&](int j) {
        if (j < i) return;
        for (const CellShare& t : shares[j]) meet(s.label, t.label, i, j);
      });
    }
  }
  std::map<Pair, std::pair<Moments, Moments>> borders;
  for (auto& [pair, near] : meeting) {
    for (int step = 0; step <= kBorderSteps; ++step) {
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      if (step == kBorderSteps) break;
      const std::size_t end = near.size();
      for (std::size_t k = 0; k < end; ++k) cells.forEachNeighbour(near[k], [&](int j) { near.push_back(j); });
    }
    auto& [first, second] = borders[pair];
    for (const int i : near) {
      for (const CellShare& s : shares[i]) {
        if (s.label == pair.first) first += s.moments;
        if (s.label == pair.second) second += s.moments;
      }
    }
  }
  return borders;
}

}  // namespace

std::vector<Moments> labelMoments(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                                  const LabelImage& labels) {
  std::vector<Moments> out(1);
  for (const auto& cell : shareCells(grid, cells, noise, labels)) {
    for (const CellShare& share : cell) {
      if (share.label >= static_cast<std::int32_t>(out.size())) out.resize(static_cast<std::size_t>(share.label) + 1);
      out[share.label] += share.moments;
    }
  }
  return out;
}

void mergeLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                 double threshold, LabelImage& labels) {
  std::vector<std::vector<CellShare>> shares = shareCells(grid, cells, noise, labels);
  std::vector<Moments> whole(1);
  for (const auto& cell : shares) {
    for (const CellShare& share : cell) {
      if (share.label >= static_cast<std::int32_t>(whole.size())) whole.resize(static_cast<std::size_t>(share.label) + 1);
      whole[share.label] += share.moments;
    }
  }
  std::vector<std::int32_t> renamed(whole.size());
  for (std::size_t i = 0; i < renamed.size(); ++i) renamed[i] = static_cast<std::int32_t>(i);
  while (true) {
    std::vector<std::pair<double, Pair>> candidates;
    for (const auto& [pair, border] : measureBorders(cells, shares)) {
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
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = static_cast<std::int32_t>(i);
    for (const auto& [s, pair] : candidates) {
      if (changed[pair.first] || changed[pair.second]) continue;
      changed[pair.first] = changed[pair.second] = true;
      whole[pair.first] += whole[pair.second];
      now[pair.second] = pair.first;
    }
    for (std::int32_t& label : renamed) label = now[label];
    for (auto& cell : shares) {
      std::vector<CellShare> joined;
      for (const CellShare& share : cell) {
        const std::int32_t label = now[share.label];
        const auto at = std::find_if(joined.begin(), joined.end(), [&](const auto& j) { return j.label == label; });
        if (at == joined.end()) {
          joined.push_back({label, share.moments});
        } else {
          at->moments += share.moments;
        }
      }
      cell = std::move(joined);
    }
  }
  for (std::int32_t& label : labels.labels) label = renamed[label];
}

}  // namespace patch_plane_clustering
