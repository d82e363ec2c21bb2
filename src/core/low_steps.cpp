// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/low_steps.h"

#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/plane_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

constexpr int kFewestMeetings = 15, kFewestPoints = 6;
constexpr double kHighest = 1.0;   // step, in standard deviations: others are told by fewer points
constexpr double kLowest = 2.0;    // in tolerances of distance
constexpr double kEvidence = 8.0;  // mean log-likelihood ratio of a window
constexpr float kTelling = 2.5F;   // least of it: where planes cross each other, nothing tells
constexpr int kLargestHalf = 12;   // of a window, in pixels
constexpr int kRounds = 2;
constexpr int kManyPoints = 16384;  // whose plane a few at a border do not turn

using Pair = CreaseMeetings::Pair;
using Step = LowStepMemory::Step;

// Sums of a rectangle's values over windows of 2 half + 1, which end where it does: down its columns, then along its rows.
void sumWindows(const std::vector<float>& values, int rows, int cols, int half_rows, int half_cols,
                std::vector<float>& columns, std::vector<float>& sums) {
  const auto width = static_cast<std::size_t>(cols);
  columns.assign(width, 0.0F);
  sums.resize(values.size());
  const auto addRow = [&](int r, float sign) {
    const float* const row = values.data() + static_cast<std::size_t>(r) * width;
    for (std::size_t c = 0; c < width; ++c) columns[c] += sign * row[c];
  };
  for (int r = 0; r < std::min(rows, half_rows); ++r) addRow(r, 1.0F);
  for (int r = 0; r < rows; ++r) {
    if (r + half_rows < rows) addRow(r + half_rows, 1.0F);
    if (r > half_rows) addRow(r - half_rows - 1, -1.0F);
    float* const out = sums.data() + static_cast<std::size_t>(r) * width;
    double sum = std::accumulate(columns.begin(), columns.begin() + std::min(cols, half_cols), 0.0);
    for (int c = 0; c < cols; ++c) {
      if (c + half_cols < cols) sum += double{columns[c + half_cols]};
      if (c > half_cols) sum -= double{columns[c - half_cols - 1]};
      out[c] = static_cast<float>(sum);
    }
  }
}

class LowStepSettler {
 public:
  LowStepSettler(const JudgedImage& image, const CreaseMeetings& meetings, double rows_per_column, LowStepMemory& memory,
                 std::vector<Eigen::Vector3d>& planes, LabelImage& labels)
      : image_(image),
        grid_(image.grid),
        meetings_(meetings),
        rows_per_column_(rows_per_column),
        memory_(memory),
        planes_(planes),
        labels_(labels) {}

  bool settleAll(const std::vector<LabelRun>& runs) {
    findSteps();
    if (memory_.steps.empty()) return false;
    memory_.first_planes = planes_;
    sumLabels(runs);
    bool changed = false;
    for (const Step& step : memory_.steps) changed = settle(step) || changed;
    return changed;
  }

 private:
  struct Rectangle {
    int top, left, rows, cols;
  };
  struct Window {
    int half_rows, half_cols;
  };

  void findSteps() {
    memory_.steps.clear();
    for (std::size_t k = 0; k < meetings_.pairs.size(); ++k) {
      const Pair& pair = meetings_.pairs[k];
      const Eigen::Vector3d &a = planes_[pair.first], &b = planes_[pair.second];
      if (!areAlmostParallel(a, b)) continue;
      const PlaneDistance distance = distanceAt(image_, meetings_, pair, a, b);
      const bool is_low = distance.in_sigmas < kHighest && distance.in_tolerances > kLowest;
      if (distance.meetings < kFewestMeetings || !is_low) continue;
      memory_.steps.push_back({static_cast<int>(k), distance.meetings, distance.in_sigmas});
    }
    std::sort(memory_.steps.begin(), memory_.steps.end(),
              [](const Step& a, const Step& b) { return std::pair(-a.meetings, a.pair) < std::pair(-b.meetings, b.pair); });
  }

  void sumLabels(const std::vector<LabelRun>& runs) {
    memory_.wanted.assign(planes_.size(), 0);
    for (const Step& step : memory_.steps) {
      const Pair& pair = meetings_.pairs[step.pair];
      for (const std::int32_t label : {pair.first, pair.second}) {
        memory_.wanted[label] = meetings_.points[label] <= kManyPoints ? 1 : 0;
      }
    }
    sumNear(image_, runs, memory_.wanted, memory_.first_planes, memory_.sums);
  }

  // Of so many points that they tell planes apart which are `height` standard deviations from each other.
  Window windowFor(double height) const {
    const double points = 2.0 * kEvidence / (height * height);
    const auto half = [](double length) {
      return std::clamp(static_cast<int>(std::lround(0.5 * (length - 1.0))), 1, kLargestHalf);
    };
    return {half(std::sqrt(points * rows_per_column_)), half(std::sqrt(points / rows_per_column_))};
  }

  // What lies around the meetings of a pair as far as its border may move.
  Rectangle rectangleOf(const Pair& pair, const Window& window) const {
    int top = grid_.rows, bottom = 0, left = grid_.cols, right = 0;
    meetings_.forEachPixel(pair, [&](int pixel) {
      const int row = pixel / grid_.cols, col = pixel % grid_.cols;
      top = std::min(top, row);
      bottom = std::max(bottom, row + 1);
      left = std::min(left, col);
      right = std::max(right, col + 1);
    });
    const int rows = 2 * (kRounds + 1) * window.half_rows, cols = 2 * (kRounds + 1) * window.half_cols;
    top = std::max(0, top - rows);
    left = std::max(0, left - cols);
    return {top, left, std::min(grid_.rows, bottom + rows) - top, std::min(grid_.cols, right + cols) - left};
  }

  bool settle(const Step& step) {
    const Pair& pair = meetings_.pairs[step.pair];
    const Window window = windowFor(step.height);
    const Rectangle rectangle = rectangleOf(pair, window);
    bool changed = false;
    for (int round = 0; round < kRounds; ++round) {
      weigh(pair, window, rectangle);
      if (!draw(pair, rectangle)) break;
      changed = true;
      for (const std::int32_t label : {pair.first, pair.second}) {
        if (memory_.wanted[label] != 0 && memory_.sums[label].n >= std::max(kFewestPoints, image_.smallest / 2))
          planes_[label] = fitPlane(memory_.sums[label]).a;
      }
    }
    return changed;
  }

  // Where both labels are near, and what tells for the second one there.
  void weigh(const Pair& pair, const Window& window, const Rectangle& rectangle) {
    const auto size = static_cast<std::size_t>(rectangle.rows) * static_cast<std::size_t>(rectangle.cols);
    const auto sum = [&](const std::vector<float>& values, int windows, std::vector<float>& sums) {
      sumWindows(values, rectangle.rows, rectangle.cols, windows * window.half_rows, windows * window.half_cols,
                 memory_.columns, sums);
    };
    memory_.of_first.resize(size);
    memory_.of_second.resize(size);
    forEachPixel(rectangle, [&](int pixel, std::size_t k) {
      memory_.of_first[k] = labels_.labels[pixel] == pair.first ? 1.0F : 0.0F;
      memory_.of_second[k] = labels_.labels[pixel] == pair.second ? 1.0F : 0.0F;
    });
    sum(memory_.of_first, 2, memory_.first_around);
    sum(memory_.of_second, 2, memory_.second_around);
    memory_.evidence.assign(size, 0.0F);
    const Eigen::Vector3d &first = planes_[pair.first], &second = planes_[pair.second];
    forEachPixel(rectangle, [&](int pixel, std::size_t k) {
      if (!isOpen(k)) return;
      const RegionPoint point = regionPointAt(image_, pixel);
      if (!(point.weight > 0.0)) return;
      memory_.evidence[k] = static_cast<float>(0.5 * (std::min(RegionPoint::kFarthest2, point.squaredError(first)) -
                                                      std::min(RegionPoint::kFarthest2, point.squaredError(second))));
    });
    sum(memory_.evidence, 1, memory_.evidence_around);
  }

  // Whether a pixel has one of both labels, and both are near.
  bool isOpen(std::size_t k) const {
    return memory_.of_first[k] + memory_.of_second[k] > 0.0F && memory_.first_around[k] > 0.0F &&
           memory_.second_around[k] > 0.0F;
  }

  // Gives points near the border the label that their windows tell for. Returns whether any has got another one.
  bool draw(const Pair& pair, const Rectangle& rectangle) {
    bool changed = false;
    forEachPixel(rectangle, [&](int pixel, std::size_t k) {
      if (!isOpen(k)) return;
      std::int32_t& label = labels_.labels[pixel];
      const float evidence = memory_.evidence_around[k];
      const std::int32_t likely = evidence > 0.0F ? pair.second : pair.first;
      if (likely == label || std::abs(evidence) < kTelling) return;
      const RegionPoint point = regionPointAt(image_, pixel);
      if (isNear(point, memory_.first_planes[label])) {
        Moments of_point;
        addPoint(point, of_point);
        memory_.sums[label] -= of_point;
      }
      if (isNear(point, memory_.first_planes[likely])) addPoint(point, memory_.sums[likely]);
      label = likely;
      changed = true;
    });
    return changed;
  }

  template <typename F>
  void forEachPixel(const Rectangle& rectangle, const F& f) const {
    std::size_t k = 0;
    for (int r = 0; r < rectangle.rows; ++r) {
      const int begin = grid_.index(rectangle.top + r, rectangle.left);
      for (int pixel = begin; pixel < begin + rectangle.cols; ++pixel) f(pixel, k++);
    }
  }

  const JudgedImage& image_;
  const BeamGrid& grid_;
  const CreaseMeetings& meetings_;
  double rows_per_column_;
  LowStepMemory& memory_;
  std::vector<Eigen::Vector3d>& planes_;
  LabelImage& labels_;
};

}  // namespace

bool settleLowSteps(const JudgedImage& image, const CreaseMeetings& meetings, const std::vector<LabelRun>& runs,
                    double rows_per_column, LowStepMemory& memory, std::vector<Eigen::Vector3d>& planes,
                    LabelImage& labels) {
  if (!image.tolerance.isWhite()) return false;
  return LowStepSettler(image, meetings, rows_per_column, memory, planes, labels).settleAll(runs);
}

}  // namespace ppc
