// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_noise.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace ppc {
namespace {

constexpr int kMinPoints = 8;  // of a patch
constexpr auto kLeastVariance = static_cast<float>(NoiseModel::kLeastFactor * NoiseModel::kLeastFactor);
constexpr float kMostVariance = 30.0F;  // over the typical one
constexpr float kAlike = 2.5F;          // factor up to which the variances of two patches are alike
constexpr double kAlikeShare = 0.6;     // of the patches around
constexpr int kFewestAlike = 5;
constexpr int kFewestBeside = 2;    // patches with more than the typical noise
constexpr int kRings = 2;           // of patches around one
constexpr int kGrowth = 2;          // steps into patches beside
constexpr int kFewestPatches = 12;  // that hang together
constexpr double kWhite = 0.6;      // of what second differences tell of the variance on typical surfaces
constexpr std::size_t kTypicalPatches = 200;
constexpr int kFewestDifferences = 4;  // of a patch

bool areAlike(float a, float b) { return a < kAlike * b && b < kAlike * a; }

// Variance of a patch's noise from second differences of its residuals, in the units of its chi-square: from line to line,
// or along the lines. Bends hardly show in them, nor does what goes on along them. Negative if there are too few.
double whiteVariance(const BeamGrid& grid, const Eigen::Vector3d& center, const Patch& patch, bool down) {
  const int step = down ? grid.cols : 1;
  const double weight = patch.moments.w / (patch.moments.n * patch.range * patch.range);
  const auto residual = [&](int i) {
    const Eigen::Vector3d p = grid.point(i).cast<double>() - center;
    return p.norm() * (1.0 - patch.fit.a.dot(p));
  };
  double squares = 0.0;
  int count = 0;
  for (int r = patch.row_begin; r < patch.row_end - (down ? 2 : 0); ++r) {
    for (int c = patch.col_begin; c < patch.col_end - (down ? 0 : 2); ++c) {
      const int i = grid.index(r, c);
      if (!grid.valid(i) || !grid.valid(i + step) || !grid.valid(i + 2 * step)) continue;
      const double difference = residual(i) - 2.0 * residual(i + step) + residual(i + 2 * step);
      squares += difference * difference;
      ++count;
    }
  }
  constexpr double kOfWhite = 6.0;  // 1 + 4 + 1
  return count < kFewestDifferences ? -1.0 : squares * weight / (kOfWhite * count);
}

// What second differences of patches tell of their variance, from line to line and along the lines: all of it where noise is
// white, less along lines along which it is correlated.
struct Whiteness {
  std::array<double, 2> sums = {};       // along, down
  std::array<double, 2> variances = {};  // of those that have such differences

  void add(const BeamGrid& grid, const Eigen::Vector3d& center, const Patch& patch, double of_patch) {
    for (const bool down : {false, true}) {
      const double white = whiteVariance(grid, center, patch, down);
      if (white < 0.0) continue;
      sums[down ? 1 : 0] += white;
      variances[down ? 1 : 0] += of_patch;
    }
  }
  // At most that of white noise: there are typical patches without any noise.
  double share(bool down) const {
    const std::size_t k = down ? 1 : 0;
    return variances[k] > 0.0 ? std::min(1.0, sums[k] / variances[k]) : 1.0;
  }
  bool isAsOf(const Whiteness& typical) const {
    return share(false) > kWhite * typical.share(false) && share(true) > kWhite * typical.share(true);
  }
};

// That of patches with about the typical noise, some of them.
Whiteness typicalWhiteness(const BeamGrid& grid, const PatchGrid& patches, const std::vector<float>& variance) {
  Whiteness typical;
  const std::size_t stride = std::max<std::size_t>(1, variance.size() / kTypicalPatches);
  for (std::size_t k = 0; k < variance.size(); k += stride) {
    if (variance[k] > 0.5F && variance[k] < 1.5F) typical.add(grid, patches.center, patches.patches[k], variance[k]);
  }
  return typical;
}

// Lists a patch and those within kRings steps of it.
void lookAround(const PatchGrid& patches, int index, std::vector<int>& around) {
  around.assign(1, index);
  std::size_t next = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    for (const std::size_t last = around.size(); next < last; ++next) {
      patches.forEachNeighbour(around[next], [&](int j) {
        if (std::find(around.begin(), around.end(), j) == around.end()) around.push_back(j);
      });
    }
  }
}

// Noise at a patch over the typical one; 1 unless the patches around tell it.
float factorAt(const BeamGrid& grid, const PatchGrid& patches, int index, const std::vector<float>& variance,
               const Whiteness& typical, SurfaceNoiseMemory::Work& work) {
  const float own = variance[index];
  if (!(own > kLeastVariance) || own > kAlike * kMostVariance) return 1.0F;
  int beside = 0;
  patches.forEachNeighbour(index, [&](int j) { beside += variance[j] > kLeastVariance ? 1 : 0; });
  if (beside < kFewestBeside) return 1.0F;  // most that noise alone makes stand by themselves
  lookAround(patches, index, work.around);
  work.variance.clear();
  int known = 0;
  for (const int j : work.around) {
    if (!(variance[j] > 0.0F)) continue;
    ++known;
    if (areAlike(variance[j], own)) work.variance.push_back(variance[j]);
  }
  const auto alike = static_cast<int>(work.variance.size());
  if (alike < kFewestAlike || alike < kAlikeShare * known) return 1.0F;
  const float found = quantile(work.variance, 0.5);
  if (!(found > kLeastVariance) || found > kMostVariance) return 1.0F;
  Whiteness whiteness;
  for (const int j : work.around) {
    if (areAlike(variance[j], own)) whiteness.add(grid, patches.center, patches.patches[j], variance[j]);
  }
  return whiteness.isAsOf(typical) ? std::sqrt(found) : 1.0F;
}

// The median factor of the patches beside a patch that have one, or 1.
float factorBeside(const PatchGrid& patches, int index, const std::vector<float>& factor, std::vector<float>& beside) {
  beside.clear();
  patches.forEachNeighbour(index, [&](int j) {
    if (factor[j] > 1.0F) beside.push_back(factor[j]);
  });
  return beside.empty() ? 1.0F : quantile(beside, 0.5);
}

// Leaves out patches of which too few hang together. @return whether any are left.
bool dropScraps(const PatchGrid& patches, SurfaceNoiseMemory& memory) {
  std::vector<float>& factor = memory.factor;
  std::vector<int>& piece = memory.piece;
  memory.reached.assign(factor.size(), 0);
  const auto reach = [&](int k) {
    if (!(factor[k] > 1.0F) || std::exchange(memory.reached[k], 1) != 0) return;
    piece.push_back(k);
  };
  bool any = false;
  for (int k = 0; k < static_cast<int>(factor.size()); ++k) {
    piece.clear();
    reach(k);
    for (std::size_t next = 0; next < piece.size(); ++next) patches.forEachNeighbour(piece[next], reach);
    const bool few = static_cast<int>(piece.size()) < kFewestPatches;
    any = any || !few;
    for (const int j : piece) factor[j] = few ? 1.0F : factor[j];
  }
  return any;
}

}  // namespace

bool adaptToSurfaces(const BeamGrid& grid, PatchGrid& patches, NoiseModel& noise, SurfaceNoiseMemory& memory, int threads) {
  const auto count = static_cast<int>(patches.patches.size());
  std::vector<float>&variance = memory.variance, &factor = memory.factor;
  variance.resize(patches.patches.size());
  factor.resize(patches.patches.size());
  forEachRange(threads, count, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Patch& patch = patches.patches[k];
      const bool known = patch.moments.n >= std::max(kMinPoints, patch.pixels() / 3);
      variance[k] = known ? static_cast<float>(patch.fit.chi2 / (patch.moments.n - 3)) : 0.0F;
    }
  });
  const Whiteness typical = typicalWhiteness(grid, patches, variance);
  forEachRange(threads, count, memory.workers, [&](int begin, int end, SurfaceNoiseMemory::Work& work) {
    for (int k = begin; k < end; ++k) factor[k] = factorAt(grid, patches, k, variance, typical, work);
  });
  if (!dropScraps(patches, memory)) return false;
  for (int step = 0; step < kGrowth; ++step) {
    memory.grown = factor;
    forEachRange(threads, count, memory.workers, [&](int begin, int end, SurfaceNoiseMemory::Work& work) {
      for (int k = begin; k < end; ++k) {
        const bool explained = variance[k] > 0.0F && variance[k] < kLeastVariance;
        if (factor[k] > 1.0F || explained || patches.patches[k].moments.n == 0) continue;
        memory.grown[k] = factorBeside(patches, k, factor, work.variance);
      }
    });
    std::swap(factor, memory.grown);
  }
  memory.pixels.assign(static_cast<std::size_t>(grid.size()), 1.0F);
  forEachRange(threads, count, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Patch& patch = patches.patches[k];
      if (!(factor[k] > 1.0F)) continue;
      patch.noise_factor = factor[k];
      patch.weigh(patch.noise_factor * patch.noise_factor);
      for (int r = patch.row_begin; r < patch.row_end; ++r) {
        std::fill_n(memory.pixels.begin() + grid.index(r, patch.col_begin), patch.col_end - patch.col_begin, factor[k]);
      }
    }
  });
  noise.setFactors(memory.pixels);
  return true;
}

}  // namespace ppc
