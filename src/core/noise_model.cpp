// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/noise_model.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace ppc {
namespace {

constexpr int kBins = 40;
constexpr double kFirst = 0.05;      // upper end of the first bin [m]
constexpr double kGrowth = 1.25;     // of one bin to the next
constexpr int kMinPoints = 8;        // of a patch
constexpr int kMinPatches = 30;      // of a bin
constexpr double kQuantile = 0.35;   // of the patches' variances: flat surfaces, not edges
constexpr double kLeeway = 1.3;      // for what other ranges tell
constexpr double kSureLeeway = 3.0;  // likewise, where surfaces tell: dark ones have up to thrice the noise of bright ones
// Of the patches of a bin, the variances of so many are within this factor of the quantile, if surfaces make it: edges and
// leaves have variances of all sizes.
constexpr std::size_t kFewForShare = 100;
constexpr double kAlike = 1.5, kAlikeShare = 0.25;
constexpr double kMinSigma = 0.0005;  // [m] finer than any time-of-flight laser

double binCenter(int bin) { return kFirst * std::pow(kGrowth, bin - 0.5); }

int binOf(double range) {
  if (!(range > kFirst)) return 0;
  return std::min(kBins - 1, 1 + static_cast<int>(std::log(range / kFirst) / std::log(kGrowth)));
}

// binOf() of many ranges without their logarithms: bins begin at ranges that are found by halving once.
class RangeBins {
 public:
  RangeBins() {
    for (int bin = 1; bin < kBins; ++bin) {
      double below = 0.0, beyond = 2.0 * binCenter(bin);
      for (double middle = 0.5 * beyond; middle > below && middle < beyond; middle = 0.5 * (below + beyond)) {
        (binOf(middle) < bin ? below : beyond) = middle;
      }
      begin_[static_cast<std::size_t>(bin)] = beyond;
    }
    for (int cell = 0; cell < kCells; ++cell) first_[static_cast<std::size_t>(cell)] = binOf(cell / kCellsPerMetre);
  }

  int of(double range) const {
    int bin = first_[static_cast<std::size_t>(std::min(std::max(range * kCellsPerMetre, 0.0), kCells - 1.0))];
    while (bin + 1 < kBins && range >= begin_[static_cast<std::size_t>(bin) + 1]) ++bin;
    return bin;
  }

 private:
  static constexpr int kCells = 1024;
  static constexpr double kCellsPerMetre = 16.0;

  std::array<double, kBins> begin_{};  // of each bin [m]
  std::array<int, kCells> first_{};    // bin of each cell of range
};

// Whether surfaces make the quantile of a bin's variances, and not edges.
bool isSure(const std::vector<double>& variances, double quantile) {
  if (variances.size() < kFewForShare) return false;
  const auto alike = std::count_if(variances.begin(), variances.end(),
                                   [&](double v) { return v > quantile / kAlike && v < quantile * kAlike; });
  return static_cast<double>(alike) > kAlikeShare * static_cast<double>(variances.size());
}

// Where few surfaces are flat, beyond windows or among leaves, even the low quantile sees edges. What flat surfaces told at
// other ranges bounds it: noise grows no faster than the square of the range (stereo, structured light) and does not fall.
// But dark walls that are near have more noise than bright ones farther away: where surfaces tell it, the leeway is larger.
void boundByOtherRanges(const std::vector<char>& sure, std::vector<double>& sigma) {
  double bound = sigma[0];
  for (int b = 1; b < kBins; ++b) {
    bound *= kGrowth * kGrowth;
    sigma[b] = std::min(sigma[b], (sure[b] != 0 ? kSureLeeway : kLeeway) * bound);
    bound = std::min(bound, sigma[b]);
  }
  for (int b = kBins - 2; b >= 0; --b) {
    bound = std::min(bound, sigma[b + 1]);
    sigma[b] = std::min(sigma[b], (sure[b] != 0 ? kSureLeeway : kLeeway) * bound);
  }
}

// Ratio of the 35 % quantile of chi-square / dof to its mean (Wilson and Hilferty 1931).
double quantileFactor(double dof) {
  constexpr double kNormalQuantile = -0.385;
  const double t = 2.0 / (9.0 * dof);
  const double root = 1.0 - t + kNormalQuantile * std::sqrt(t);
  return root * root * root;
}

// The same for the numbers of points that most patches have, which are few: roots and divisions once each.
class QuantileFactors {
 public:
  QuantileFactors() {
    for (int n = kMinPoints; n < kKnown; ++n) factors_[static_cast<std::size_t>(n)] = quantileFactor(n - 3);
  }
  double of(int n) const { return n < kKnown ? factors_[static_cast<std::size_t>(n)] : quantileFactor(n - 3); }

 private:
  static constexpr int kKnown = 256;
  std::array<double, kKnown> factors_{};
};

// Variances of the patches that have points enough, bin by bin.
void sortVariances(const PatchGrid& patches, NoiseMemory& memory, int threads) {
  std::vector<int>&bin = memory.bin, &begin = memory.bin_begin;
  bin.resize(patches.patches.size());
  memory.variance.resize(bin.size());
  static const QuantileFactors factors;
  static const RangeBins bins;
  forEachRange(threads, static_cast<int>(bin.size()), [&](int first, int last) {
    for (int p = first; p < last; ++p) {
      const Patch& patch = patches.patches[p];
      bin[p] = patch.moments.n < kMinPoints ? -1 : bins.of(patch.range);
      const double dof = patch.moments.n - 3;
      if (bin[p] >= 0) memory.variance[p] = patch.fit.chi2 / dof / factors.of(patch.moments.n);
    }
  });
  begin.assign(kBins + 1, 0);
  for (const int b : bin) {
    if (b >= 0) ++begin[b + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  memory.variances.resize(static_cast<std::size_t>(begin.back()));
  for (std::size_t p = 0; p < bin.size(); ++p) {
    if (bin[p] >= 0) memory.variances[begin[bin[p]]++] = memory.variance[p];
  }
  std::rotate(begin.begin(), begin.end() - 1, begin.end());  // each has moved on to the beginning of the next
  begin.front() = 0;
}

}  // namespace

NoiseModel::NoiseModel(const std::vector<double>& sigma_of_bin) {
  const auto binAt = [](int cell) { return binOf((cell + 0.5) / kCellsPerMetre); };
  for (int begin = 0, end = 0; begin < kCells; begin = end) {
    const int bin = binAt(begin);
    int beyond = kCells;
    for (end = begin + 1; end < beyond;) {  // bins are wide: their ends are found by halving
      const int middle = end + (beyond - end) / 2;
      if (binAt(middle) == bin) {
        end = middle + 1;
      } else {
        beyond = middle;
      }
    }
    std::fill(table_.begin() + begin, table_.begin() + end, sigma_of_bin[bin]);
  }
}

NoiseModel::NoiseModel(const SensorModel& sensor, double scale) {
  for (int i = 0; i < kCells; ++i) table_[i] = std::max(kMinSigma, scale * sensor.sigma((i + 0.5) / kCellsPerMetre));
}

NoiseModel NoiseModel::estimate(const PatchGrid& patches, const SensorModel& sensor) {
  NoiseMemory memory;
  return estimate(patches, sensor, memory);
}

NoiseModel NoiseModel::estimate(const PatchGrid& patches, const SensorModel& sensor, NoiseMemory& memory, int threads) {
  sortVariances(patches, memory, threads);
  std::vector<double>& sigma = memory.sigma;
  sigma.resize(kBins);
  std::vector<char>& sure = memory.sure;
  sure.assign(kBins, 0);
  struct Variances {
    int begin, end;
  };
  std::array<Variances, kBins> of_bin{};
  for (int b = 0; b < kBins; ++b) {
    // Thin bins borrow from their neighbours, nearest first.
    int reach = 0;
    Variances& of = of_bin[static_cast<std::size_t>(b)];
    do {
      of = {memory.bin_begin[std::max(0, b - reach)], memory.bin_begin[std::min(kBins, b + reach + 1)]};
    } while (++reach < kBins && of.end - of.begin < kMinPatches);
  }
  const auto as_before = [&](int b) {  // far from any, bins borrow the same
    const Variances &of = of_bin[static_cast<std::size_t>(b)],
                    &before = of_bin[static_cast<std::size_t>(std::max(0, b - 1))];
    return b > 0 && of.begin < of.end && of.begin == before.begin && of.end == before.end;
  };
  forEachPart(threads, kBins, memory.pools, [&](int b, std::vector<double>& pool) {
    const Variances& of = of_bin[static_cast<std::size_t>(b)];
    if (as_before(b)) return;
    pool.assign(memory.variances.begin() + of.begin, memory.variances.begin() + of.end);
    if (pool.empty()) {
      sigma[b] = sensor.sigma(binCenter(b));
      return;
    }
    const double variance = quantile(pool, kQuantile);
    sigma[b] = std::max(kMinSigma, std::sqrt(variance));
    sure[b] = isSure(pool, variance) ? 1 : 0;
  });
  for (int b = 1; b < kBins; ++b) {
    if (!as_before(b)) continue;
    sigma[b] = sigma[b - 1];
    sure[b] = sure[b - 1];
  }
  boundByOtherRanges(sure, sigma);
  return NoiseModel(sigma);
}

}  // namespace ppc
