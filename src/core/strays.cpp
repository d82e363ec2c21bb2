// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/strays.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

constexpr int kSampledRows = 32;
constexpr double kLeastShare = 0.015;         // of the sampled points, from which it is worth while
constexpr int kRounds = 2;                    // strays beside strays show once those are gone
constexpr int kNeighbours[kRounds] = {5, 4};  // measured ones, at least
constexpr float kFar = 5.0F;                  // in standard deviations
// Noise that any laser may have, or range steps; and that none has: there are ranges at which all points are strays.
constexpr float kLeastNoise = 0.002F, kLeastRelative = 0.003F;
constexpr float kMostNoise = 0.03F, kMostRelative = 0.02F;
constexpr std::size_t kMinSamples = 50;  // of a range
constexpr double kShare = 0.25;          // of the samples; so many are smaller than this many standard deviations:
constexpr double kShareToSigma = 1.0 / (0.3186 * 2.4495);

int binOf(float range, int bins) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &range, sizeof bits);
  constexpr int kBitsBelow = 22, kFirst = 2 * (127 - 20);  // exponent and one bit more; 2^-20 m
  return std::clamp(static_cast<int>(bits >> kBitsBelow) - kFirst, 0, bins - 1);
}

// @param fewest neighbours that must have been measured.
bool isStray(const BeamGrid& grid, const float* ranges, int row, int col, float limit, int fewest) {
  const int i = grid.index(row, col);
  const float range = ranges[i], nearest = range - limit, farthest = range + limit;
  int measured = 0, not_nearer = 0, not_farther = 0;
  for (int r = std::max(0, row - 1); r <= std::min(grid.rows - 1, row + 1); ++r) {
    for (int c = std::max(0, col - 1); c <= std::min(grid.cols - 1, col + 1); ++c) {
      const int j = grid.index(r, c);
      if (j == i || !(ranges[j] > 0.0F)) continue;
      ++measured;
      not_nearer += ranges[j] >= nearest ? 1 : 0;
      not_farther += ranges[j] <= farthest ? 1 : 0;
    }
  }
  return measured >= fewest && std::min(not_nearer, not_farther) <= 1;
}

// Whether a point is far from both beside it in the row, at the lowest of limits: what most points are not costs little.
bool mayBeStray(const float* at) {
  const float least = kFar * (kLeastNoise + kLeastRelative * at[0]);
  return (at[-1] > at[0] + least && at[1] > at[0] + least) || (at[-1] < at[0] - least && at[1] < at[0] - least);
}

// Share of the points in the sampled rows that `is` tells to be strays.
template <typename F>
double shareOf(const BeamGrid& grid, const std::vector<int>& rows, F&& is) {
  int points = 0, strays = 0;
  for (const int r : rows) {
    for (int c = 1; c + 1 < grid.cols; ++c) {
      const int i = grid.index(r, c);
      if (!grid.valid(i)) continue;
      ++points;
      strays += is(r, c, i) ? 1 : 0;
    }
  }
  return points > 0 ? static_cast<double>(strays) / points : 0.0;
}

}  // namespace

void StrayLimits::measure(const BeamGrid& grid, const std::vector<int>& sampled,
                          std::vector<std::vector<float>>& differences) {
  differences.resize(kBins);
  for (std::vector<float>& of_bin : differences) of_bin.clear();
  for (const int r : sampled) {
    for (int c = 0; c < grid.cols; ++c) {
      const int i = grid.index(r, c);
      const float range = grid.range[i];
      const float difference = std::abs(grid.range[i - grid.cols] - 2.0F * range + grid.range[i + grid.cols]);
      if (std::isfinite(difference)) differences[binOf(range, kBins)].push_back(difference);
    }
  }
  sigma_.fill(0.0F);
  for (int bin = 0; bin < kBins; ++bin) {
    std::vector<float>& of_bin = differences[bin];
    if (of_bin.size() >= kMinSamples) sigma_[bin] = static_cast<float>(kShareToSigma) * quantile(of_bin, kShare);
  }
}

float StrayLimits::at(float range) const {
  const float sigma = sigma_[binOf(range, kBins)];
  return kFar * std::clamp(sigma, kLeastNoise + kLeastRelative * range, kMostNoise + kMostRelative * range);
}

bool clearStrays(const BeamGrid& grid, StrayMemory& memory, int threads) {
  std::vector<int>& sampled = memory.sampled;
  sampled.clear();
  for (int r = 1; r + 1 < grid.rows; r += std::max(1, grid.rows / kSampledRows)) sampled.push_back(r);
  if (shareOf(grid, sampled, [&](int, int, int i) { return mayBeStray(&grid.range[i]); }) < kLeastShare) return false;
  memory.limits.measure(grid, sampled, memory.differences);
  const auto is_stray = [&](int r, int c, int i) {
    return isStray(grid, grid.range.data(), r, c, memory.limits.at(grid.range[i]), kNeighbours[0]);
  };
  if (shareOf(grid, sampled, is_stray) < kLeastShare) return false;
  memory.grid = grid;
  for (const int fewest : kNeighbours) {
    memory.ranges = memory.grid.range;
    const float* const ranges = memory.ranges.data();
    forEachRange(threads, grid.rows, [&](int begin, int end) {
      for (int r = begin; r < end; ++r) {
        for (int c = 0; c < grid.cols; ++c) {
          const int i = grid.index(r, c);
          if (!(ranges[i] > 0.0F) || !isStray(grid, ranges, r, c, memory.limits.at(ranges[i]), fewest)) continue;
          memory.grid.range[i] = std::numeric_limits<float>::quiet_NaN();
        }
      }
    });
  }
  return true;
}

}  // namespace ppc
