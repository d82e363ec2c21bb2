// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/strays.h"

#include "patch_plane_clustering/core/grid_lines.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace ppc {
namespace {

constexpr int kSampledRows = 32;
constexpr double kLeastShare = 0.015;    // of the sampled points, from which it is worth while
constexpr int kLeastSide = 8;            // of the image [pixels]
constexpr int kRounds = 2;               // strays beside strays show once those are gone
constexpr int kNeighboursOnSide = 2;     // of three that have been measured, at least
constexpr float kLeastDistance = 0.1F;   // from neighbours [m]
constexpr float kLeastRelative = 0.03F;  // and over the range

float limitAt(float range) { return kLeastDistance + kLeastRelative * range; }

// Where a side has not been measured (sky, borders), what there is of a surface seen at a grazing angle may well be nearer
// throughout, so a point there is none. @param row,col not at the border of the image.
bool isStray(const BeamGrid& grid, const float* ranges, int row, int col) {
  const int i = grid.index(row, col);
  const float range = ranges[i], nearest = range - limitAt(range), farthest = range + limitAt(range);
  const float before = ranges[i - 1], after = ranges[i + 1];
  if (before >= nearest && before <= farthest && after >= nearest && after <= farthest) return false;  // as most
  std::array<int, 3> of_row{}, of_col{};
  int not_nearer = 0, not_farther = 0;  // of the measured ones
  for (int r = -1; r <= 1; ++r) {
    for (int c = -1; c <= 1; ++c) {
      const float other = ranges[i + r * grid.cols + c];
      if ((r == 0 && c == 0) || !(other > 0.0F)) continue;
      ++of_row[static_cast<std::size_t>(r + 1)];
      ++of_col[static_cast<std::size_t>(c + 1)];
      not_nearer += other >= nearest ? 1 : 0;
      not_farther += other <= farthest ? 1 : 0;
    }
  }
  return std::min({of_row[0], of_row[2], of_col[0], of_col[2]}) >= kNeighboursOnSide &&
         std::min(not_nearer, not_farther) <= 1;
}

// Whether a point is far from both beside it in the row: what most points are not costs little.
bool mayBeStray(const float* at) {
  const float nearest = at[0] - limitAt(at[0]), farthest = at[0] + limitAt(at[0]);
  return (at[-1] > farthest && at[1] > farthest) || (at[-1] < nearest && at[1] < nearest);
}

// Share of the points in a sample of rows that `is` tells to be strays.
template <typename F>
double shareOf(const BeamGrid& grid, F&& is) {
  int points = 0, strays = 0;
  const int stride = std::max(1, grid.rows / kSampledRows);
  for (int k = 0; k < grid.rows / stride; ++k) {
    const int r = sampledLine(k, stride);
    if (r == 0 || r + 1 >= grid.rows) continue;
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

bool clearStrays(const BeamGrid& grid, StrayMemory& memory, int threads) {
  if (std::min(grid.rows, grid.cols) < kLeastSide) return false;
  if (shareOf(grid, [&](int, int, int i) { return mayBeStray(&grid.range[i]); }) < kLeastShare) return false;
  const auto is_stray = [&](int r, int c, int) { return isStray(grid, grid.range.data(), r, c); };
  if (shareOf(grid, is_stray) < kLeastShare) return false;
  memory.grid = grid;
  for (int round = 0; round < kRounds; ++round) {
    memory.ranges = memory.grid.range;
    const float* const ranges = memory.ranges.data();
    forEachRange(threads, grid.rows - 2, [&](int begin, int end) {
      for (int r = 1 + begin; r < 1 + end; ++r) {
        for (int c = 1; c + 1 < grid.cols; ++c) {
          const int i = grid.index(r, c);
          if (!(ranges[i] > 0.0F) || !isStray(grid, ranges, r, c)) continue;
          memory.grid.range[i] = std::numeric_limits<float>::quiet_NaN();
        }
      }
    });
  }
  return true;
}

}  // namespace ppc
