// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/range_limit.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kFewestPoints = 6;
constexpr int kFewestPixels = 400;     // that tell of holes
constexpr double kFarthest = 1.5;      // standard deviations of noise from the farthest patch
constexpr double kMostMeasured = 0.9;  // share of the pixels there, if the range ends
constexpr double kReach = 6.0;         // standard deviations before the limit: a patch is as deep as it is oblique
constexpr double kWhole = 0.95;        // share of a patch's pixels of which none are missed

}  // namespace

std::optional<double> findRangeLimit(const PatchGrid& patches, const NoiseModel& noise) {
  double farthest = 0.0;
  for (const Patch& patch : patches.patches) {
    if (patch.range > farthest && patch.moments.n >= std::max(kFewestPoints, patch.pixels() / 3)) farthest = patch.range;
  }
  const double begin = farthest - kFarthest * noise.sigma(farthest);
  long pixels = 0, measured = 0;
  for (const Patch& patch : patches.patches) {
    if (patch.range < begin || patch.moments.n == 0) continue;
    pixels += patch.pixels();
    measured += patch.moments.n;
  }
  if (pixels < kFewestPixels || static_cast<double>(measured) > kMostMeasured * static_cast<double>(pixels))
    return std::nullopt;
  return farthest;
}

void markTruncated(const BeamGrid& grid, const std::optional<double>& limit, const NoiseModel& noise, PatchGrid& patches) {
  if (!limit) return;
  const double begin = *limit - kReach * noise.sigma(*limit);
  patches.truncated.assign(patches.patches.size(), 0);
  for (std::size_t k = 0; k < patches.patches.size(); ++k) {
    Patch& patch = patches.patches[k];
    if (patch.range < begin || patch.moments.n == 0) continue;
    int measured = 0;  // also those that the patch was made without
    for (int r = patch.row_begin; r < patch.row_end; ++r) {
      for (int i = grid.index(r, patch.col_begin); i < grid.index(r, patch.col_end); ++i) measured += grid.valid(i) ? 1 : 0;
    }
    if (measured > kWhole * patch.pixels()) continue;
    patches.truncated[k] = 1;
    patch.planar = false;
  }
}

}  // namespace ppc
