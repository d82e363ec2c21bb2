// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/clustering.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <map>
#include <utility>

namespace patch_plane_clustering {
namespace {

constexpr int kMinPatchPoints = 6;

constexpr double kWholeTolerance = 2.5;  // tolerance over a whole cluster over that from patch to patch
constexpr double kStepTolerance = 1.25;  // tolerance of a step along the border of two clusters, likewise
constexpr double kMaxRadius = 0.5;       // [m]
constexpr int kBorderSteps = 2;          // depth of a border in patches

// Root mean square distance of the points from their mean [m].
double radius(const Moments& m) {
  const Eigen::Vector3d mean = m.mean();
  const double spread = (m.xx + m.yy + m.zz) / m.w - mean.squaredNorm();
  return std::sqrt(std::max(0.0, spread));
}

double excess(const Moments& a, const PlaneFit& fit_a, const Moments& b, const PlaneFit& fit_b) {
  return fitPlane(a + b).chi2 - fit_a.chi2 - fit_b.chi2;
}

// Moments of the patches of a cluster within a few steps of its given border patches.
Moments nearBorder(const PatchGrid& grid, const std::vector<int>& cluster_of, int cluster, std::vector<int> patches) {
  std::sort(patches.begin(), patches.end());
  patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  for (int step = 0; step < kBorderSteps; ++step) {
    const std::size_t end = patches.size();
    for (std::size_t k = 0; k < end; ++k) {
      grid.forEachNeighbour(patches[k], [&](int j) {
        if (cluster_of[j] == cluster) patches.push_back(j);
      });
    }
    std::sort(patches.begin(), patches.end());
    patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  }
  Moments sum;
  for (const int i : patches) sum += grid.patches[i].moments;
  return sum;
}

// Gaussian similarity of two strips along a common border: how far apart they lie across the joint plane. The strips' own
// slopes are left out, for a tilted plane would pass through any step.
double continuity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                  const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d mean_a = a.mean(), mean_b = b.mean();
  const double gap = joint.normal().dot(mean_a - mean_b);
  const double range = 0.5 * (mean_a.norm() + mean_b.norm());
  const double sigma = noise.sigma(range);
  const double variance = sigma * sigma / secantSquared(joint.a, range) * (1.0 / a.n + 1.0 / b.n) * tolerance.inflation;
  const double step = kStepTolerance * tolerance.sigma_distance;
  return std::exp(-0.5 * gap * gap / (variance + step * step));
}

}  // namespace

void weighPatches(const NoiseModel& noise, PatchGrid& grid) {
  for (Patch& patch : grid.patches) {
    const double sigma = noise.sigma(patch.range);
    patch.moments.scale(1.0 / (sigma * sigma));
  }
}

void gatePatches(const NoiseModel& noise, const CoplanarityTolerance& tolerance, PatchGrid& grid) {
  for (Patch& patch : grid.patches) {
    patch.planar = false;
    const int pixels = (patch.row_end - patch.row_begin) * (patch.col_end - patch.col_begin);
    if (patch.moments.n < std::max(kMinPatchPoints, pixels / 3)) continue;
    patch.fit = fitPlane(patch.moments);
    const double sigma = noise.sigma(patch.range);
    const double dof = patch.moments.n - 3;
    const double sec2 = secantSquared(patch.fit.a, patch.range);
    const double slack = tolerance.sigma_distance * tolerance.sigma_distance * sec2 / (sigma * sigma);
    patch.planar = patch.fit.chi2 < dof * (1.0 + slack) + 3.3 * std::sqrt(2.0 * dof * tolerance.inflation);
  }
}

double estimateInflation(const PatchGrid& grid) {
  std::vector<double> excesses;
  for (int i = 0; i < static_cast<int>(grid.patches.size()); ++i) {
    const Patch& patch = grid.patches[i];
    if (!patch.planar) continue;
    grid.forEachNeighbour(i, [&](int j) {
      const Patch& other = grid.patches[j];
      if (j < i || !other.planar) return;
      excesses.push_back(excess(patch.moments, patch.fit, other.moments, other.fit));
    });
  }
  if (excesses.size() < 100) return 1.0;
  constexpr double kChiSquare3Quantile = 1.4237;  // 30 %
  const auto at = excesses.begin() + static_cast<std::ptrdiff_t>(0.3 * static_cast<double>(excesses.size()));
  std::nth_element(excesses.begin(), at, excesses.end());
  return std::clamp(*at / kChiSquare3Quantile, 1.0, 25.0);
}

PatchClusters growClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                           double threshold) {
  const int n = static_cast<int>(grid.patches.size());
  PatchClusters out;
  out.cluster_of.assign(n, -1);

  // Seeds: patches whose whole neighbourhood is flat come first; there the first steps are safe.
  std::vector<double> roughness(n, 1e30);
  std::vector<int> seeds;
  for (int i = 0; i < n; ++i) {
    const Patch& patch = grid.patches[i];
    if (!patch.planar) continue;
    Moments around = patch.moments;
    int missing = 4;
    grid.forEachNeighbour(i, [&](int j) {
      if (!grid.patches[j].planar) return;
      around += grid.patches[j].moments;
      --missing;
    });
    roughness[i] = fitPlane(around).chi2 / std::max(1, around.n - 3) + std::max(0, missing);
    seeds.push_back(i);
  }
  std::stable_sort(seeds.begin(), seeds.end(), [&](int a, int b) { return roughness[a] < roughness[b]; });

  std::vector<int> queue;
  for (const int seed : seeds) {
    if (out.cluster_of[seed] >= 0) continue;
    const int id = static_cast<int>(out.clusters.size());
    Cluster cluster;
    cluster.moments = grid.patches[seed].moments;
    cluster.fit = grid.patches[seed].fit;
    out.cluster_of[seed] = id;
    queue.assign(1, seed);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      grid.forEachNeighbour(queue[head], [&](int j) {
        const Patch& patch = grid.patches[j];
        if (!patch.planar || out.cluster_of[j] >= 0) return;
        const Moments joint = cluster.moments + patch.moments;
        const PlaneFit fit = fitPlane(joint);
        const double sigma = noise.sigma(patch.range);
        const double precision = std::min(patch.moments.n, cluster.moments.n) / (sigma * sigma);
        const double s = similarity(fit.chi2 - cluster.fit.chi2 - patch.fit.chi2, precision, radius(patch.moments),
                                    secantSquared(fit.a, patch.range), tolerance);
        if (s < threshold) return;
        cluster.moments = joint;
        cluster.fit = fit;
        out.cluster_of[j] = id;
        queue.push_back(j);
      });
    }
    cluster.patches = queue;
    out.clusters.push_back(std::move(cluster));
  }
  return out;
}

void mergeClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                   PatchClusters& clusters) {
  // Over a whole wall the tolerance is wider than from patch to patch (walls bow), but where two clusters meet they must agree.
  CoplanarityTolerance whole = tolerance;
  whole.sigma_distance *= kWholeTolerance;
  const auto similarityOf = [&](const Moments& a, const Moments& b, const CoplanarityTolerance& allowed) {
    const Moments& small = a.n < b.n ? a : b;
    const PlaneFit joint = fitPlane(a + b);
    const double range = small.mean().norm();
    const double sigma = noise.sigma(range);
    return similarity(joint.chi2 - fitPlane(a).chi2 - fitPlane(b).chi2, small.n / (sigma * sigma),
                      std::min(radius(small), kMaxRadius), secantSquared(joint.a, range), allowed);
  };
  while (true) {
    std::map<std::pair<int, int>, std::pair<std::vector<int>, std::vector<int>>> borders;
    for (int i = 0; i < static_cast<int>(grid.patches.size()); ++i) {
      const int a = clusters.cluster_of[i];
      if (a < 0) continue;
      grid.forEachNeighbour(i, [&](int j) {
        const int b = clusters.cluster_of[j];
        if (b <= a) return;
        auto& border = borders[{a, b}];
        border.first.push_back(i);
        border.second.push_back(j);
      });
    }
    std::vector<std::pair<double, std::pair<int, int>>> candidates;
    for (const auto& [pair, border] : borders) {
      const double s = similarityOf(clusters.clusters[pair.first].moments, clusters.clusters[pair.second].moments, whole);
      if (s < threshold) continue;
      const Moments here = nearBorder(grid, clusters.cluster_of, pair.first, border.first);
      const Moments there = nearBorder(grid, clusters.cluster_of, pair.second, border.second);
      const PlaneFit joint = fitPlane(clusters.clusters[pair.first].moments + clusters.clusters[pair.second].moments);
      if (continuity(here, there, joint, noise, tolerance) >= threshold) candidates.push_back({-s, pair});
    }
    if (candidates.empty()) return;
    std::sort(candidates.begin(), candidates.end());
    std::vector<bool> changed(clusters.clusters.size(), false);
    for (const auto& candidate : candidates) {
      const auto [a, b] = candidate.second;
      if (changed[a] || changed[b]) continue;
      changed[a] = changed[b] = true;
      Cluster& into = clusters.clusters[a];
      Cluster& from = clusters.clusters[b];
      into.moments += from.moments;
      into.fit = fitPlane(into.moments);
      for (const int i : from.patches) clusters.cluster_of[i] = a;
      into.patches.insert(into.patches.end(), from.patches.begin(), from.patches.end());
      from = Cluster();
    }
  }
}

}  // namespace patch_plane_clustering
