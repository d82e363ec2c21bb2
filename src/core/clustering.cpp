// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/clustering.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/patch_roughness.h"
#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/core/running_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace ppc {
namespace {

constexpr int kMinPatchPoints = 6;
// Standard deviation of a patch's distance, in tolerances of the distance, beyond which its surroundings are asked too:
constexpr double kOneRing = 0.7;
constexpr double kTwoRings = 1.5;
constexpr double kNearlyOneRing = 0.69;  // less, for patches that may be beyond
constexpr int kClusterSizes = 3;         // size of a cluster over that of such surroundings before they are asked
using Seed = std::pair<double, int>;     // roughness and index of a patch
constexpr char kNotPlanar = 0, kPlanar = 1, kUncertain = 2;
constexpr int kInflationPatches = 3000;
constexpr int kFewPatches = 2000;  // not worth a second thread
// Of the seeds, so many are sorted at a time: what is no worse than the pivot of a sample.
constexpr std::ptrdiff_t kFewSeeds = 256, kSampledSeeds = 128, kPivotRank = 4;

// Noise of a patch's ranges, on whatever surface it lies.
double sigmaOf(const Patch& patch, const NoiseModel& noise) { return noise.sigma(patch.range) * patch.noise_factor; }

double excess(const Moments& a, const PlaneFit& fit_a, const Moments& b, const PlaneFit& fit_b) {
  return fitPlane(a + b).chi2 - fit_a.chi2 - fit_b.chi2;
}

// Comparisons simpler than the default, so that what it buys can be measured.
double plainSimilarity(const Patch& from, const PlaneFit& cluster, const Patch& patch, const NoiseModel& noise,
                       const CoplanarityTolerance& tolerance, const PatchComparison& comparison) {
  if (!comparison.noise_aware) {
    const Eigen::Vector3d border = 0.5 * (from.moments.mean() + patch.moments.mean());
    return fixedSimilarity(comparison.running_plane ? cluster.a : from.fit.a, patch.fit.a, border, tolerance);
  }
  const PlaneFit joint = fitPlane(from.moments + patch.moments);
  const double sigma = sigmaOf(patch, noise);
  const double precision = std::min(patch.moments.n, from.moments.n) / (sigma * sigma);
  return similarity(joint.chi2 - from.fit.chi2 - patch.fit.chi2, precision, patch.moments.radius(),
                    secantSquared(joint.a, patch.range), tolerance.forNoise(sigma));
}

// Residuals as small as the noise and the tolerance allow.
bool isFlat(const Moments& m, const PlaneFit& fit, double range, double sigma, const CoplanarityTolerance& tolerance) {
  const double dof = m.n - 3;
  const double distance = tolerance.forNoise(sigma).sigma_distance;
  const double slack = distance * distance * secantSquared(fit.a, range) / (sigma * sigma);
  return fit.chi2 < dof * (1.0 + slack) + 3.3 * std::sqrt(2.0 * dof * tolerance.inflationOf(m.n));
}

void weigh(const NoiseModel& noise, const PatchGrid& grid, Patch& patch) {
  patch.noise_factor =
      noise.factorAt((patch.row_begin + patch.row_end) / 2 * grid.cols + (patch.col_begin + patch.col_end) / 2);
  const double sigma = sigmaOf(patch, noise);
  patch.weigh(sigma * sigma);
}

void gate(const NoiseModel& noise, const CoplanarityTolerance& tolerance, Patch& patch) {
  patch.planar = patch.moments.n >= std::max(kMinPatchPoints, patch.pixels() / 3) &&
                 isFlat(patch.moments, patch.fit, patch.range, sigmaOf(patch, noise), tolerance);
}

// Finds the surroundings of those patches in [begin, end) that are to be asked together with them.
void measureSurroundings(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                         const GrowthMemory& memory, int begin, int end, FoundSurroundings& result) {
  result.of.clear();
  result.around.clear();
  bool any = false;
  for (int i = begin; i < end; ++i) {
    if (memory.kind[i] != kUncertain) continue;
    const Patch& patch = grid.patches[i];
    const double sigma = sigmaOf(patch, noise);
    const double uncertainty =
        sigma * std::sqrt(tolerance.inflation / (patch.moments.n * secantSquared(patch.fit.a, patch.range)));
    const double distance = tolerance.forNoise(sigma).sigma_distance;
    const int rings = uncertainty > kTwoRings * distance ? 2 : uncertainty > kOneRing * distance ? 1 : 0;
    if (rings == 0) continue;
    if (!std::exchange(any, true)) result.reached.assign(grid.patches.size(), -1);
    std::vector<int>& wave = result.wave;
    const auto take = [&](int j) {
      if (result.reached[j] == i || !grid.patches[j].planar) return;
      result.reached[j] = i;
      wave.push_back(j);
    };
    wave.clear();
    take(i);
    std::size_t next = 0;
    for (int ring = 0; ring < rings; ++ring) {
      const std::size_t last = wave.size();
      for (; next < last; ++next) grid.forEachNeighbour(wave[next], take);
    }
    Moments sum;
    for (const int j : wave) sum += grid.patches[j].moments;
    const PlaneFit fit = fitPlane(sum);
    if (!isFlat(sum, fit, patch.range, sigma, tolerance)) continue;
    result.of.push_back(i);
    result.around.push_back({sum, fit, sum.radius(), tolerance.inflationOf(sum.n)});
  }
}

void measureSurroundings(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                         GrowthMemory& memory, int threads) {
  const int parts = std::max(1, threads), count = static_cast<int>(grid.patches.size());
  std::vector<FoundSurroundings>& found = memory.found;
  found.resize(static_cast<std::size_t>(parts));
  forEachPart(threads, parts, [&](int part) {
    measureSurroundings(grid, noise, tolerance, memory, partBegin(count, parts, part), partBegin(count, parts, part + 1),
                        found[part]);
  });
  for (const FoundSurroundings& part : found) {
    for (std::size_t k = 0; k < part.of.size(); ++k) {
      memory.around_of[part.of[k]] = static_cast<int>(memory.around.size());
      memory.around.push_back(part.around[k]);
    }
  }
}

// Sorts the best of the seeds from `next` on, which are those before the returned place.
std::vector<Seed>::iterator sortBest(std::vector<Seed>& seeds, std::vector<Seed>::iterator next) {
  const std::ptrdiff_t rest = seeds.end() - next;
  auto best_end = seeds.end();
  if (rest > kFewSeeds) {
    std::array<Seed, kSampledSeeds> sample;
    for (std::ptrdiff_t k = 0; k < kSampledSeeds; ++k) sample[static_cast<std::size_t>(k)] = next[k * rest / kSampledSeeds];
    std::nth_element(sample.begin(), sample.begin() + kPivotRank, sample.end());
    const Seed pivot = sample[kPivotRank];
    best_end = std::partition(next, seeds.end(), [&](const Seed& seed) { return !(pivot < seed); });
  }
  std::sort(next, best_end);
  return best_end;
}

// What growth asks of every planar patch. No patch has surroundings or a cluster yet.
void measurePatches(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                    GrowthMemory& memory, PatchClusters& out, int threads) {
  for (std::vector<double>* numbers : {&memory.roughness, &memory.radius, &memory.precision}) {
    numbers->resize(grid.patches.size());
  }
  memory.kind.resize(grid.patches.size());
  memory.around_of.resize(grid.patches.size());
  out.cluster_of.resize(grid.patches.size());
  forEachRange(threads, static_cast<int>(grid.patches.size()), [&](int begin, int end) {
    PatchRoughness roughness(memory.roughness);
    for (int i = begin; i < end; ++i) {
      const Patch& patch = grid.patches[i];
      memory.kind[i] = kNotPlanar;
      memory.around_of[i] = out.cluster_of[i] = -1;
      if (!patch.planar) continue;
      roughness.add(grid, i);
      const double radius = patch.moments.radius(), sigma = sigmaOf(patch, noise), n = patch.moments.n;
      const double distance = tolerance.forNoise(sigma).sigma_distance, turned = tolerance.sigma_angle * radius;
      memory.radius[i] = radius;
      memory.precision[i] = n / (sigma * sigma) * (distance * distance + turned * turned);
      const double limit = kNearlyOneRing * distance;
      const bool uncertain =
          sigma * sigma * tolerance.inflation > limit * limit * n * secantSquared(patch.fit.a, patch.range);
      memory.kind[i] = uncertain ? kUncertain : kPlanar;
    }
  });
}

}  // namespace

void weighPatches(const NoiseModel& noise, PatchGrid& grid, int threads) {
  forEachRange(threads, static_cast<int>(grid.patches.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) weigh(noise, grid, grid.patches[k]);
  });
}

void gatePatches(const NoiseModel& noise, const CoplanarityTolerance& tolerance, PatchGrid& grid, int threads) {
  forEachRange(threads, static_cast<int>(grid.patches.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k) gate(noise, tolerance, grid.patches[k]);
  });
}

void weighAndGatePatches(const NoiseModel& noise, const CoplanarityTolerance& tolerance, PatchGrid& grid, int threads) {
  constexpr int kAtATime = 16;  // stay at hand; no weight waits for a gate that was not foreseen
  forEachRange(threads, static_cast<int>(grid.patches.size()), [&](int begin, int end) {
    for (int first = begin; first < end; first += kAtATime) {
      const int last = std::min(first + kAtATime, end);
      for (int k = first; k < last; ++k) weigh(noise, grid, grid.patches[k]);
      for (int k = first; k < last; ++k) gate(noise, tolerance, grid.patches[k]);
    }
  });
}

double estimateInflation(const PatchGrid& grid) {
  InflationMemory memory;
  for (int part = 0; part < kSampleParts; ++part) sampleInflation(grid, part, memory);
  return inflationOf(memory);
}

void sampleInflation(const PatchGrid& grid, int part, InflationMemory& memory) {
  std::vector<double>& excesses = memory.excesses[static_cast<std::size_t>(part)];
  excesses.clear();
  forEachSample(static_cast<int>(grid.patches.size()), kInflationPatches, part, [&](int i) {
    const Patch& patch = grid.patches[i];
    if (!patch.planar) return;
    grid.forEachNeighbour(i, [&](int j) {
      const Patch& other = grid.patches[j];
      if (j < i || !other.planar) return;
      excesses.push_back(excess(patch.moments, patch.fit, other.moments, other.fit));
    });
  });
}

double inflationOf(InflationMemory& memory) {
  std::vector<double>& all = memory.excesses[0];
  for (std::size_t part = 1; part < memory.excesses.size(); ++part) append(memory.excesses[part], all);
  if (all.size() < 100) return 1.0;
  constexpr double kChiSquare3Quantile = 1.4237;  // 30 %
  const auto rank = static_cast<std::size_t>(0.3 * static_cast<double>(all.size()));
  return std::clamp(valueOfRank(all, rank) / kChiSquare3Quantile, 1.0, 25.0);
}

PatchClusters growClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                           double threshold, const PatchComparison& comparison) {
  GrowthMemory memory;
  PatchClusters out;
  growClusters(grid, noise, tolerance, threshold, comparison, memory, out);
  return out;
}

void growClusters(const PatchGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                  const PatchComparison& comparison, GrowthMemory& memory, PatchClusters& out, int threads) {
  const int n = static_cast<int>(grid.patches.size());
  out.clusters.clear();
  out.members.clear();

  const bool plain = !comparison.running_plane || !comparison.noise_aware;

  // Seeds: patches whose whole neighbourhood is flat come first; there the first steps are safe.
  if (n < kFewPatches) threads = 1;
  measurePatches(grid, noise, tolerance, memory, out, threads);
  const std::vector<double>& radius = memory.radius;
  memory.seeds.clear();
  for (int i = 0; i < n; ++i) {
    if (memory.kind[i] != kNotPlanar) memory.seeds.emplace_back(memory.roughness[i], i);
  }
  memory.around.clear();
  if (!plain) measureSurroundings(grid, noise, tolerance, memory, threads);

  const double greatest = greatestMisfit(threshold), noise_misfit = 3.0 * tolerance.inflation;
  std::vector<int>& queue = out.members;
  const auto grown = [&](const Seed& seed) { return out.cluster_of[seed.second] >= 0; };
  auto sorted_end = memory.seeds.begin();
  for (auto next = memory.seeds.begin(); next != memory.seeds.end(); ++next) {
    if (next == sorted_end) {  // the best of the rest; later on most of them have grown into a cluster
      memory.seeds.erase(std::remove_if(next, memory.seeds.end(), grown), memory.seeds.end());
      if (next == memory.seeds.end()) break;
      sorted_end = sortBest(memory.seeds, next);
    }
    const int seed = next->second;
    if (grown(*next)) continue;
    const int id = static_cast<int>(out.clusters.size());
    Cluster cluster;
    RunningPlane plane(grid.patches[seed].moments, grid.patches[seed].fit);
    out.cluster_of[seed] = id;
    cluster.begin = static_cast<int>(queue.size());
    queue.push_back(seed);
    for (auto head = static_cast<std::size_t>(cluster.begin); head < queue.size(); ++head) {
      const int at = queue[head];
      const Patch& from = grid.patches[at];
      grid.forEachNeighbour(at, [&](int j) {
        if (out.cluster_of[j] >= 0) return;  // most of them, and their patches need not be read
        const Patch& patch = grid.patches[j];
        if (!patch.planar) return;
        if (plain) {
          if (plainSimilarity(from, plane.fit(), patch, noise, tolerance, comparison) < threshold) return;
        } else if (memory.around_of[j] >= 0 ||
                   !plane.surelySuits(patch.moments, patch.fit,
                                      noise_misfit + memory.precision[j] * secantSquared(plane.about(), patch.range),
                                      greatest)) {
          const double sigma = sigmaOf(patch, noise);
          const CoplanarityTolerance local = tolerance.forNoise(sigma);
          const double points = std::min(patch.moments.n, plane.moments().n);
          if (!plane.suits({patch.moments, patch.fit, radius[j], patch.range, sigma, points}, local, greatest)) return;
          const int around = memory.around_of[j];
          if (around >= 0 && plane.moments().n > kClusterSizes * memory.around[around].moments.n) {
            const Surroundings& wide = memory.around[around];
            CoplanarityTolerance of_wide = local;
            of_wide.inflation = wide.inflation;
            const auto wide_points = static_cast<double>(wide.moments.n);
            if (!plane.suits({wide.moments, wide.fit, wide.radius, patch.range, sigma, wide_points}, of_wide, greatest))
              return;
          }
        }
        plane.join(patch.moments);
        out.cluster_of[j] = id;
        queue.push_back(j);
      });
    }
    cluster.end = static_cast<int>(queue.size());
    cluster.moments = plane.moments();
    cluster.fit = plane.fit();
    out.clusters.push_back(cluster);
  }
}

}  // namespace ppc
