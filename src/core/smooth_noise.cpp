// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/smooth_noise.h"

#include "patch_plane_clustering/core/grid_selection.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/point_square.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ppc {
namespace {

constexpr int kFar = 4, kNextToLast = 6, kLast = 8;  // pixels between points
constexpr int kBetween[] = {2, 3, kFar};
constexpr int kPlaces = 16, kFewPlaces = 8;  // along rows and columns, where residuals are compared, at a first look too
constexpr double kFewest = 0.25;             // share of those places at which planes could be fitted
constexpr int kFewestLines = 40;             // rows and columns that must be left
constexpr double kSmooth = 1.4;              // growth up to kFar, at nearly all places; of independent errors 0.7 to 1.0
constexpr double kSmoothAlong = 1.2;         // where only rows, or only columns, are so far apart; of independent errors 0.9
constexpr double kSaturated = 1.5;           // growth at kLast over that at kNextToLast; 1.8 if the surface itself bends
constexpr double kHarmful = 2.5;             // growth at kLast beyond what is tolerated
constexpr double kEnough = 0.52;             // of that growth, of points so far apart: neighbours show what noise does
constexpr double kAlike = -0.08;             // correlation of points side by side, in the median; of independent errors -0.2
constexpr double kFarthest = 4.0;            // standard deviations that a point of a region may be off

// Calls f(pixel) for so many places along rows and columns, spread over the image.
template <typename F>
void forEachPlace(const BeamGrid& grid, int side, const F& f) {
  if (grid.size() == 0) return;
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) f(grid.index((2 * r + 1) * grid.rows / (2 * side), (2 * c + 1) * grid.cols / (2 * side)));
  }
}

// Lists the places around which all points so many pixels apart were measured. @return whether there are enough.
bool listPlaces(const BeamGrid& grid, int side, int stride, std::vector<SmoothNoiseMemory::Place>& places) {
  places.clear();
  forEachPlace(grid, side, [&](int pixel) {
    if (!PointSquare::isMeasured(grid, pixel, stride, stride)) return;
    if (const auto near = PointSquare::around(grid, pixel)) places.push_back({pixel, near->residual()});
  });
  return static_cast<int>(places.size()) >= kFewest * side * side;
}

// How many times as large residuals are with rows and columns so many pixels apart as they are side by side.
struct Growth {
  double least = 0.0;      // at all but one place of ten: planes break off at others, or bend, which makes it larger
  double planar = 0.0;     // where surfaces are planar, if most are not
  double tolerated = 0.0;  // of residuals to which the tolerance of planes is added, in the median
};

Growth growthAt(const BeamGrid& grid, int row_stride, int col_stride, double tolerance, SmoothNoiseMemory& memory) {
  std::vector<double>&bare = memory.values[0], &tolerated = memory.values[1];
  bare.clear();
  tolerated.clear();
  for (const SmoothNoiseMemory::Place& place : memory.places) {
    const auto square = PointSquare::around(grid, place.pixel, row_stride, col_stride);
    if (!square) continue;
    const double far = square->residual();
    bare.push_back(far / std::max(place.residual, 1e-6));
    tolerated.push_back(std::hypot(far, tolerance) / std::max(std::hypot(place.residual, tolerance), 1e-6));
  }
  if (bare.empty()) return {};
  return {quantile(bare, 0.1), quantile(bare, 0.3), median(tolerated)};
}

// Pixels between points that show half of what noise does over many; 1 where they do so side by side, where smooth noise
// does no harm, and where nothing can be told.
int thinningStride(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory) {
  const auto growth = [&](int rows, int cols) { return growthAt(grid, rows, cols, tolerance, memory); };
  for (const int side : {kFewPlaces, kPlaces}) {
    if (!listPlaces(grid, side, kFar, memory.places) || growth(kFar, kFar).least < kSmooth) return 1;
  }
  if (std::min(growth(kFar, 1).planar, growth(1, kFar).planar) < kSmoothAlong) return 1;
  if (!listPlaces(grid, kPlaces, kLast, memory.places)) return 1;
  const Growth last = growth(kLast, kLast), before = growth(kNextToLast, kNextToLast);
  if (last.tolerated < kHarmful || last.planar > kSaturated * before.planar) return 1;
  const double enough = kEnough * last.tolerated;
  int stride = before.tolerated < enough ? kLast : kNextToLast;
  for (const int shorter : kBetween) {
    if (growth(shorter, shorter).tolerated < enough) continue;
    stride = shorter;
    break;
  }
  return std::min(grid.rows, grid.cols) < stride * kFewestLines ? 1 : stride;
}

// The middle ones of every `stride` lines of `count`, and between which of them each line lies.
void chooseLines(int count, int stride, std::vector<int>& kept, std::vector<SmoothNoiseMemory::Between>& between) {
  kept.clear();
  for (int line = stride / 2; line < count; line += stride) kept.push_back(line);
  between.clear();
  const int last = static_cast<int>(kept.size()) - 1;
  for (int line = 0; line < count; ++line) {
    const int before = std::clamp((line - stride / 2) / stride, 0, last), after = std::min(before + 1, last);
    const float along = static_cast<float>(line - kept[before]) / static_cast<float>(stride);
    between.push_back({before, after, std::clamp(along, 0.0F, 1.0F)});
  }
}

// Planes of the regions of the thinned image.
void fitRegions(const Eigen::Vector3d& center, SmoothNoiseMemory& memory) {
  const std::vector<std::int32_t>& labels = memory.labels.labels;
  const std::int32_t most = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  memory.regions.assign(static_cast<std::size_t>(most) + 1, {});
  for (int i = 0; i < memory.grid.size(); ++i) {
    if (labels[i] != 0 && memory.grid.valid(i)) addPoint(memory.grid, i, center, memory.regions[labels[i]].moments);
  }
  for (SmoothNoiseMemory::ThinnedRegion& region : memory.regions) {
    const Moments& m = region.moments;
    if (m.n == 0) continue;
    const PlaneFit fit = fitPlane(m);
    region.a = fit.a;
    region.farthest = kFarthest * std::sqrt(fit.chi2 / std::max(1, m.n - 3));
    region.range2 = m.w / m.n;
  }
}

// Finds labels of pixels among those of the kept ones around them.
class ThinnedLabels {
 public:
  ThinnedLabels(const BeamGrid& grid, const Eigen::Vector3d& center, const SmoothNoiseMemory& memory)
      : grid_(grid), center_(center), memory_(memory) {}

  std::int32_t operator()(int row, int col) const {
    const int pixel = grid_.index(row, col);
    if (!grid_.valid(pixel)) return 0;
    const SmoothNoiseMemory::Between &r = memory_.row_between[row], &c = memory_.col_between[col];
    const std::int32_t label = labelAt(r.before, c.before);
    if (label == labelAt(r.before, c.after) && label == labelAt(r.after, c.before) && label == labelAt(r.after, c.after)) {
      return label <= 0 || !allows(memory_.regions[label], pixel) ? 0 : label;
    }
    return bestLabel(pixel, r, c);
  }

 private:
  static constexpr std::int32_t kUnknown = -1;
  struct Vote {
    std::int32_t label = 0;
    float weight = 0.0F;
  };

  // That of a kept pixel; kUnknown if it was not measured.
  std::int32_t labelAt(int row, int col) const {
    const int kept = memory_.grid.index(row, col);
    return memory_.grid.valid(kept) ? memory_.labels.labels[kept] : kUnknown;
  }

  std::int32_t bestLabel(int pixel, const SmoothNoiseMemory::Between& r, const SmoothNoiseMemory::Between& c) const {
    const float down = r.along, right = c.along;
    std::array<Vote, 4> votes;
    add(r.before, c.before, (1.0F - down) * (1.0F - right), votes);
    add(r.before, c.after, (1.0F - down) * right, votes);
    add(r.after, c.before, down * (1.0F - right), votes);
    add(r.after, c.after, down * right, votes);
    std::int32_t label = 0;
    float most = 0.0F;
    for (const Vote& vote : votes) {
      if (vote.weight <= most || (vote.label != 0 && !allows(memory_.regions[vote.label], pixel))) continue;
      label = vote.label;
      most = vote.weight;
    }
    return label;
  }

  // A pixel that was not measured does not vote.
  void add(int row, int col, float weight, std::array<Vote, 4>& votes) const {
    const std::int32_t label = labelAt(row, col);
    if (weight <= 0.0F || label == kUnknown) return;
    for (Vote& vote : votes) {
      if (vote.weight > 0.0F && vote.label != label) continue;
      vote.label = label;
      vote.weight += weight;
      return;
    }
  }

  // Whether the point of a pixel may be one of the region. Errors of stereo cameras grow with the square of the range.
  bool allows(const SmoothNoiseMemory::ThinnedRegion& region, int pixel) const {
    const double slope = region.a.dot(grid_.direction(pixel).cast<double>()), range = grid_.range[pixel];
    const double off = std::abs(1.0 - region.a.dot(grid_.point(pixel).cast<double>() - center_));
    return off <= region.farthest * slope * std::max(1.0, range * range / region.range2);
  }

  const BeamGrid& grid_;
  const Eigen::Vector3d center_;
  const SmoothNoiseMemory& memory_;
};

}  // namespace

bool thinSmoothNoise(const BeamGrid& grid, double tolerance, SmoothNoiseMemory& memory) {
  memory.stride = thinningStride(grid, tolerance, memory);
  if (memory.stride == 1) return false;
  chooseLines(grid.rows, memory.stride, memory.rows, memory.row_between);
  chooseLines(grid.cols, memory.stride, memory.cols, memory.col_between);
  selectBeams(grid, memory.rows, memory.cols, memory.grid);
  return true;
}

bool areErrorsAlikeAround(const BeamGrid& grid, SmoothNoiseMemory& memory) {
  std::vector<double>&rows = memory.values[0], &columns = memory.values[1];
  rows.clear();
  columns.clear();
  forEachPlace(grid, kPlaces, [&](int pixel) {
    const auto square = PointSquare::around(grid, pixel);
    if (!square) return;
    rows.push_back(square->alongRows());
    columns.push_back(square->alongColumns());
  });
  return static_cast<int>(rows.size()) >= kFewest * kPlaces * kPlaces && median(rows) > kAlike && median(columns) > kAlike;
}

void labelThinned(const BeamGrid& grid, const Eigen::Vector3d& center, SmoothNoiseMemory& memory, LabelImage& labels,
                  int threads) {
  fitRegions(center, memory);
  labels.rows = grid.rows;
  labels.cols = grid.cols;
  labels.labels.resize(static_cast<std::size_t>(grid.size()));
  const ThinnedLabels label_of(grid, center, memory);
  forEachRange(threads, grid.rows, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < grid.cols; ++col) labels.labels[grid.index(row, col)] = label_of(row, col);
    }
  });
}

}  // namespace ppc
