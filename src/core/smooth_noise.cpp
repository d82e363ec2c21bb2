// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/smooth_noise.h"

#include "patch_plane_clustering/core/grid_selection.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace ppc {
namespace {

constexpr int kSide = 4;                             // points of a side of what planes are fitted to
constexpr int kFar = 4, kNextToLast = 6, kLast = 8;  // pixels between them
constexpr int kBetween[] = {2, 3, kFar, kNextToLast};
constexpr int kPlaces = 16;           // along rows and columns, where residuals are compared
constexpr std::size_t kFewest = 64;   // of those places at which planes could be fitted
constexpr double kSmooth = 1.4;       // growth up to kFar, at nearly all places; of independent errors 0.7 to 1.0
constexpr double kSaturated = 1.5;    // growth at kLast over that at kNextToLast; 1.8 if the surface itself bends
constexpr double kHarmful = 2.5;      // growth at kLast beyond what is tolerated
constexpr double kIndependent = 0.5;  // of that growth: points are far enough apart
constexpr double kFarthest = 4.0;     // standard deviations that a point of a region may be off

// Root mean square of what the points around a pixel are off their plane, along the beams; none if one was not measured.
std::optional<double> residual(const BeamGrid& grid, int row, int col, int stride) {
  const int top = row - kSide / 2 * stride, left = col - kSide / 2 * stride;
  if (top < 0 || left < 0 || top + (kSide - 1) * stride >= grid.rows || left + (kSide - 1) * stride >= grid.cols) return {};
  const Eigen::Vector3f origin = grid.origin(grid.index(row, col));
  Moments moments;
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      const int i = grid.index(top + r * stride, left + c * stride);
      if (!grid.valid(i)) return {};
      const Eigen::Vector3d p = (grid.point(i) - origin).cast<double>();
      const double range = grid.range[i];
      moments.add(p.x(), p.y(), p.z(), range * range);
    }
  }
  return std::sqrt(fitPlane(moments).chi2 / (kSide * kSide - 3));
}

// How many times as large residuals are with points so many pixels apart as they are side by side.
struct Growth {
  double least;      // at all but one place of ten: planes break off at others, or bend, which makes it larger
  double planar;     // where surfaces are planar, if most are not
  double tolerated;  // of residuals to which the tolerance of planes is added, in the median
};

// All 0 if there are too few places.
Growth growthAt(const BeamGrid& grid, int stride, double tolerance, SmoothNoiseMemory& memory) {
  std::vector<double>&bare = memory.bare, &tolerated = memory.tolerated;
  bare.clear();
  tolerated.clear();
  for (const SmoothNoiseMemory::Residual& near : memory.residuals) {
    const std::optional<double> far = residual(grid, near.pixel / grid.cols, near.pixel % grid.cols, stride);
    if (!far) continue;
    bare.push_back(*far / std::max(near.near, 1e-6));
    tolerated.push_back(std::hypot(*far, tolerance) / std::hypot(near.near, tolerance));
  }
  if (bare.size() < kFewest) return {};
  return {quantile(bare, 0.1), quantile(bare, 0.3), median(tolerated)};
}

// Pixels between points whose errors are independent; 1 where they are so side by side, or nearly, or nothing can be told.
int independentStride(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory) {
  memory.residuals.clear();
  for (int r = 0; r < kPlaces; ++r) {
    for (int c = 0; c < kPlaces; ++c) {
      const int row = (2 * r + 1) * grid.rows / (2 * kPlaces), col = (2 * c + 1) * grid.cols / (2 * kPlaces);
      if (const std::optional<double> near = residual(grid, row, col, 1)) {
        memory.residuals.push_back({grid.index(row, col), *near});
      }
    }
  }
  if (memory.residuals.size() < kFewest || growthAt(grid, kFar, tolerance, memory).least < kSmooth) return 1;
  const Growth last = growthAt(grid, kLast, tolerance, memory);
  if (last.tolerated < kHarmful) return 1;
  if (last.planar > kSaturated * growthAt(grid, kNextToLast, tolerance, memory).planar) return 1;
  for (const int stride : kBetween) {
    if (growthAt(grid, stride, tolerance, memory).tolerated >= kIndependent * last.tolerated) return stride;
  }
  return kLast;
}

// The middle ones of every `stride` lines of `count`, and where each line lies among them.
void chooseLines(int count, int stride, std::vector<int>& kept, std::vector<SmoothNoiseMemory::Place>& places) {
  kept.clear();
  for (int line = stride / 2; line < count; line += stride) kept.push_back(line);
  places.clear();
  const int last = static_cast<int>(kept.size()) - 1;
  for (int line = 0; line < count; ++line) {
    const int before = std::clamp((line - stride / 2) / stride, 0, last), after = std::min(before + 1, last);
    const float along = static_cast<float>(line - kept[before]) / static_cast<float>(stride);
    places.push_back({before, after, std::clamp(along, 0.0F, 1.0F)});
  }
}

// Planes of the regions of the thinned image.
void fitRegions(const Eigen::Vector3f& center, SmoothNoiseMemory& memory) {
  const std::vector<std::int32_t>& labels = memory.labels.labels;
  const std::int32_t most = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  memory.regions.assign(static_cast<std::size_t>(most) + 1, {});
  for (int i = 0; i < memory.grid.size(); ++i) {
    if (labels[i] == 0 || !memory.grid.valid(i)) continue;
    const Eigen::Vector3d p = (memory.grid.point(i) - center).cast<double>();
    const double range = memory.grid.range[i];
    memory.regions[labels[i]].moments.add(p.x(), p.y(), p.z(), range * range);
  }
  for (SmoothNoiseMemory::ThinnedRegion& region : memory.regions) {
    const PlaneFit fit = fitPlane(region.moments);
    region.a = fit.a.cast<float>();
    region.farthest = static_cast<float>(kFarthest * std::sqrt(fit.chi2 / std::max(1, region.moments.n - 3)));
  }
}

// Finds labels of pixels among those of the kept ones around them.
class ThinnedLabels {
 public:
  ThinnedLabels(const BeamGrid& grid, const Eigen::Vector3f& center, const SmoothNoiseMemory& memory)
      : grid_(grid), center_(center), memory_(memory) {}

  std::int32_t operator()(int row, int col) const {
    const int pixel = grid_.index(row, col);
    if (!grid_.valid(pixel)) return 0;
    const SmoothNoiseMemory::Place &r = memory_.row_places[row], &c = memory_.col_places[col];
    Vote votes[4];
    const float along_row = c.along, along_col = r.along;
    add(r.before, c.before, (1.0F - along_col) * (1.0F - along_row), votes);
    add(r.before, c.after, (1.0F - along_col) * along_row, votes);
    add(r.after, c.before, along_col * (1.0F - along_row), votes);
    add(r.after, c.after, along_col * along_row, votes);
    const Vote* best = nullptr;
    for (const Vote& vote : votes) {
      if (vote.weight < 0.0F || (best != nullptr && vote.weight <= best->weight)) continue;
      if (vote.label == 0 || allows(memory_.regions[vote.label], pixel)) best = &vote;
    }
    return best == nullptr ? 0 : best->label;
  }

 private:
  struct Vote {
    std::int32_t label = 0;
    float weight = -1.0F;  // negative: none
  };

  void add(int row, int col, float weight, Vote (&votes)[4]) const {
    const int kept = memory_.grid.index(row, col);
    if (!memory_.grid.valid(kept)) return;
    const std::int32_t label = memory_.labels.labels[kept];
    for (Vote& vote : votes) {
      if (vote.weight >= 0.0F && vote.label != label) continue;
      vote.weight = std::max(0.0F, vote.weight) + weight;
      vote.label = label;
      return;
    }
  }

  // Whether the point of a pixel may be one of the region.
  bool allows(const SmoothNoiseMemory::ThinnedRegion& region, int pixel) const {
    const float slope = region.a.dot(grid_.direction(pixel));
    return std::abs(1.0F - region.a.dot(grid_.point(pixel) - center_)) <= region.farthest * slope;
  }

  const BeamGrid& grid_;
  const Eigen::Vector3f center_;
  const SmoothNoiseMemory& memory_;
};

}  // namespace

bool thinSmoothNoise(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory) {
  const int stride = independentStride(grid, tolerance, memory);
  if (stride == 1) return false;
  chooseLines(grid.rows, stride, memory.rows, memory.row_places);
  chooseLines(grid.cols, stride, memory.cols, memory.col_places);
  selectBeams(grid, memory.rows, memory.cols, memory.grid);
  return true;
}

void labelThinned(const BeamGrid& grid, const Eigen::Vector3d& center, SmoothNoiseMemory& memory, LabelImage& labels) {
  const Eigen::Vector3f about = center.cast<float>();
  fitRegions(about, memory);
  labels.rows = grid.rows;
  labels.cols = grid.cols;
  labels.labels.resize(static_cast<std::size_t>(grid.size()));
  const ThinnedLabels label_of(grid, about, memory);
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) labels.labels[grid.index(row, col)] = label_of(row, col);
  }
}

}  // namespace ppc
