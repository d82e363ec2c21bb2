// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/segcomp.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace ppc {
namespace {

using Sizes = std::map<std::int32_t, int>;

void keep(const Sizes& sizes, const std::map<std::int32_t, bool>& ignored, std::vector<std::int32_t>& ids,
          std::vector<int>& counts) {
  for (const auto& [id, size] : sizes) {
    if (ignored.count(id) != 0) continue;
    ids.push_back(id);
    counts.push_back(size);
  }
}

int indexOf(const std::vector<std::int32_t>& ids, std::int32_t id) {
  const auto at = std::lower_bound(ids.begin(), ids.end(), id);
  return at != ids.end() && *at == id ? static_cast<int>(at - ids.begin()) : -1;
}

// One region that several others cover: an instance of over-segmentation (whole = true, parts = found) or of
// under-segmentation (the other way round).
struct Split {
  bool over = true;
  int whole = 0;
  std::vector<int> parts;
  double measure = 0.0;
};

}  // namespace

RegionOverlap overlapOf(const LabelImage& truth, const LabelImage& found, int min_region) {
  if (truth.rows != found.rows || truth.cols != found.cols) {
    throw std::invalid_argument("labels of " + std::to_string(found.rows) + " x " + std::to_string(found.cols) +
                                " pixels against a truth of " + std::to_string(truth.rows) + " x " +
                                std::to_string(truth.cols));
  }
  Sizes true_sizes, found_sizes;
  std::map<std::pair<std::int32_t, std::int32_t>, int> common;
  for (std::size_t i = 0; i < truth.labels.size(); ++i) {
    const std::int32_t t = std::max(0, truth.labels[i]);
    const std::int32_t f = std::max(0, found.labels[i]);
    if (t > 0) ++true_sizes[t];
    if (f > 0) ++found_sizes[f];
    if (t > 0 || f > 0) ++common[{t, f}];
  }
  RegionOverlap overlap;
  std::map<std::int32_t, bool> ignored_true, ignored_found;
  for (const auto& [id, size] : true_sizes) {
    if (size < min_region) ignored_true[id] = true;
  }
  Sizes on_ignored;
  for (const auto& [pair, n] : common) {
    if (pair.second > 0 && ignored_true.count(pair.first) != 0) on_ignored[pair.second] += n;
  }
  for (const auto& [id, n] : on_ignored) {
    if (2 * n > found_sizes[id]) ignored_found[id] = true;
  }
  overlap.ignored_true = static_cast<int>(ignored_true.size());
  overlap.ignored_found = static_cast<int>(ignored_found.size());
  keep(true_sizes, ignored_true, overlap.true_ids, overlap.true_sizes);
  keep(found_sizes, ignored_found, overlap.found_ids, overlap.found_sizes);
  overlap.common.assign(overlap.true_ids.size(), std::vector<int>(overlap.found_ids.size(), 0));
  for (const auto& [pair, n] : common) {
    if (ignored_true.count(pair.first) != 0) continue;
    if (pair.first > 0) overlap.planar_true += n;
    if (pair.second > 0) overlap.planar_found += n;
    if (pair.first > 0 && pair.second > 0) overlap.planar_both += n;
    const int t = indexOf(overlap.true_ids, pair.first);
    const int f = indexOf(overlap.found_ids, pair.second);
    if (t >= 0 && f >= 0) overlap.common[t][f] = n;
  }
  return overlap;
}

SegcompScore segcomp(const RegionOverlap& overlap, double tolerance) {
  if (!(tolerance > 0.5 && tolerance <= 1.0)) throw std::invalid_argument("tolerance must be above 0.5 and at most 1");
  const int n_true = static_cast<int>(overlap.true_ids.size());
  const int n_found = static_cast<int>(overlap.found_ids.size());
  const auto of_true = [&](int t, int f) { return static_cast<double>(overlap.common[t][f]) / overlap.true_sizes[t]; };
  const auto of_found = [&](int t, int f) { return static_cast<double>(overlap.common[t][f]) / overlap.found_sizes[f]; };

  SegcompScore score;
  score.tolerance = tolerance;
  std::vector<bool> true_used(n_true, false), found_used(n_found, false);
  for (int t = 0; t < n_true; ++t) {
    for (int f = 0; f < n_found; ++f) {
      if (of_true(t, f) < tolerance || of_found(t, f) < tolerance) continue;
      score.matches.emplace_back(t, f);
      true_used[t] = found_used[f] = true;
    }
  }
  score.correct = static_cast<int>(score.matches.size());

  std::vector<Split> splits;
  const auto collect = [&](bool over, int n_wholes, int n_parts) {
    for (int whole = 0; whole < n_wholes; ++whole) {
      Split split{over, whole, {}, 0.0};
      double covered = 0.0, parts = 0.0;
      for (int part = 0; part < n_parts; ++part) {
        const double share = over ? of_found(whole, part) : of_true(part, whole);
        if (share < tolerance) continue;
        split.parts.push_back(part);
        parts += share;
        covered += over ? of_true(whole, part) : of_found(part, whole);
      }
      if (split.parts.size() < 2 || covered < tolerance) continue;
      split.measure = covered + parts / static_cast<double>(split.parts.size());
      splits.push_back(split);
    }
  };
  collect(true, n_true, n_found);
  collect(false, n_found, n_true);
  std::stable_sort(splits.begin(), splits.end(), [](const Split& a, const Split& b) { return a.measure > b.measure; });
  for (const Split& split : splits) {
    auto& wholes = split.over ? true_used : found_used;
    auto& parts = split.over ? found_used : true_used;
    const bool taken =
        wholes[split.whole] || std::any_of(split.parts.begin(), split.parts.end(), [&](int part) { return parts[part]; });
    if (taken) continue;
    wholes[split.whole] = true;
    for (const int part : split.parts) parts[part] = true;
    ++(split.over ? score.over_segmented : score.under_segmented);
  }
  score.missed = static_cast<int>(std::count(true_used.begin(), true_used.end(), false));
  score.noise = static_cast<int>(std::count(found_used.begin(), found_used.end(), false));
  return score;
}

OverlapScore overlapScore(const RegionOverlap& overlap) {
  OverlapScore score;
  double sum = 0.0, weighted = 0.0, pixels = 0.0;
  for (std::size_t t = 0; t < overlap.true_ids.size(); ++t) {
    double best = 0.0;
    for (std::size_t f = 0; f < overlap.found_ids.size(); ++f) {
      const int both = overlap.common[t][f];
      best = std::max(best, static_cast<double>(both) / (overlap.true_sizes[t] + overlap.found_sizes[f] - both));
    }
    sum += best;
    weighted += best * overlap.true_sizes[t];
    pixels += overlap.true_sizes[t];
  }
  const bool none = overlap.true_ids.empty();
  score.mean_iou = none ? 1.0 : sum / static_cast<double>(overlap.true_ids.size());
  score.weighted_iou = none ? 1.0 : weighted / pixels;
  const auto both = static_cast<double>(overlap.planar_both);
  score.precision = overlap.planar_found > 0 ? both / static_cast<double>(overlap.planar_found) : 1.0;
  score.recall = overlap.planar_true > 0 ? both / static_cast<double>(overlap.planar_true) : 1.0;
  return score;
}

double f1(const RegionOverlap& overlap, const SegcompScore& score) {
  const std::size_t all = overlap.true_ids.size() + overlap.found_ids.size();
  return all == 0 ? 1.0 : 2.0 * score.correct / static_cast<double>(all);
}

}  // namespace ppc
