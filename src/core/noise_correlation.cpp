// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/noise_correlation.h"

#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ppc {
namespace {

constexpr int kPatches = 1000;              // at which squares begin
constexpr int kSide = 2, kWideSide = 4;     // of squares whose planes are compared, and of those for the variance [patches]
constexpr std::size_t kMinPairs = 100;      // of squares
constexpr double kMaxSquareVariance = 2.0;  // over the noise: other squares are not flat
constexpr double kExcessQuantile = 0.3;     // low, for many a square lies on an edge
constexpr double kChiSquare3Quantile = 1.4237;  // of that much
constexpr double kVarianceQuantile = 0.35;
constexpr double kQuietGrowth = 1.15;    // of inflation from patches to squares that white noise may show
constexpr double kQuietVariance = 1.35;  // of the variance: less is what patches and their inflation allow for
constexpr double kMaxVariance = 2.0;

// The sum of side x side patches in a square that begins at a pixel; false unless all are there and planar.
bool sumSquare(const PatchGrid& grid, int row, int col, int height, int side, Moments& sum) {
  int last = -1;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      const int r = row + y * height, c = col + x * grid.strip_cols;
      const int i = r < grid.rows && c < grid.cols ? grid.patchAt(r, c) : -1;
      if (i < 0 || i == last || !grid.patches[i].planar) return false;
      last = i;
      sum += grid.patches[i].moments;
    }
  }
  return true;
}

}  // namespace

NoiseCorrelation measureCorrelation(const PatchGrid& grid, double inflation) {
  CorrelationMemory memory;
  for (int part = 0; part < kSampleParts; ++part) sampleCorrelation(grid, part, memory);
  return correlationOf(memory, inflation);
}

void sampleCorrelation(const PatchGrid& grid, int part, CorrelationMemory& memory) {
  auto& [excesses, variances, points] = memory.parts[static_cast<std::size_t>(part)];
  for (std::vector<double>* numbers : {&excesses, &variances, &points}) numbers->clear();
  forEachSample(static_cast<int>(grid.patches.size()), kPatches, part, [&](int i) {
    const Patch& patch = grid.patches[i];
    const int height = patch.row_end - patch.row_begin;
    Moments a;
    if (!sumSquare(grid, patch.row_begin, patch.col_begin, height, kSide, a)) return;
    const PlaneFit fit_a = fitPlane(a);
    if (fit_a.chi2 > kMaxSquareVariance * (a.n - 3)) return;
    points.push_back(patch.moments.n);
    Moments wide;
    if (sumSquare(grid, patch.row_begin, patch.col_begin, height, kWideSide, wide)) {
      variances.push_back(fitPlane(wide).chi2 / (wide.n - 3));
    }
    for (const auto& [down, right] : {std::pair(kSide * height, 0), std::pair(0, kSide * grid.strip_cols)}) {
      Moments b;
      if (!sumSquare(grid, patch.row_begin + down, patch.col_begin + right, height, kSide, b)) continue;
      const PlaneFit fit_b = fitPlane(b);
      if (fit_b.chi2 > kMaxSquareVariance * (b.n - 3)) continue;
      excesses.push_back(fitPlane(a + b).chi2 - fit_a.chi2 - fit_b.chi2);
    }
  });
}

NoiseCorrelation correlationOf(CorrelationMemory& memory, double inflation) {
  auto& [excesses, variances, points] = memory.parts[0];
  for (std::size_t part = 1; part < memory.parts.size(); ++part) {
    const CorrelationMemory::Samples& more = memory.parts[part];
    append(more.excesses, excesses);
    append(more.variances, variances);
    append(more.points, points);
  }
  NoiseCorrelation found;
  found.points = points.empty() ? 1.0 : quantile(points, 0.5);
  if (excesses.size() < kMinPairs) return found;
  const double variance = variances.size() < kMinPairs ? 1.0 : quantile(variances, kVarianceQuantile);
  if (variance < kQuietVariance) return found;
  found.variance = std::min(variance, kMaxVariance);
  const double growth = quantile(excesses, kExcessQuantile) / kChiSquare3Quantile / inflation;
  if (growth > kQuietGrowth) {
    found.growth = std::min(1.0, std::log(growth / kQuietGrowth) / std::log(static_cast<double>(kSide * kSide)));
  }
  return found;
}

}  // namespace ppc
