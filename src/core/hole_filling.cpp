// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/hole_filling.h"

#include "patch_plane_clustering/core/label_runs.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

constexpr double kMaxMean = 4.0;     // mean distance of a speck, in standard deviations of such a mean
constexpr double kMaxScatter = 6.0;  // mean square of its distances, in variances of noise and tolerance

class HoleFiller {
 public:
  HoleFiller(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
             const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, HoleMemory& memory,
             LabelImage& labels)
      : grid_(grid),
        planes_(planes),
        center_(center),
        noise_(noise),
        tolerance_(tolerance),
        smallest_(smallest),
        labels_(labels.labels),
        loose_(memory.loose),
        seen_(memory.seen),
        speck_(memory.speck) {
    loose_.resize(planes.size());
    seen_.assign(static_cast<std::size_t>(grid.size()), 0);
    std::vector<int>& points = memory.points;
    points.assign(planes.size(), 0);
    forEachRun(labels, [&](std::int32_t label, int begin, int end) { points[label] += end - begin; });
    for (std::size_t label = 0; label < loose_.size(); ++label)
      loose_[label] = label == 0 || points[label] < smallest ? 1 : 0;
  }

  void fillAll() {
    for (int begin = 0, end = 0; begin < grid_.size(); begin = end) {
      end = runEnd(labels_.data(), begin, grid_.size());
      if (loose_[labels_[begin]] == 0) continue;
      for (int i = begin; i < end; ++i) {
        if (seen_[i] == 0 && grid_.valid(i)) fillFrom(i);
      }
    }
  }

 private:
  void fillFrom(int first) {
    const std::int32_t around = collect(first);
    if (around == 0 || static_cast<int>(speck_.size()) >= smallest_ || !belongs(planes_[around])) return;
    for (const int i : speck_) labels_[i] = around;
  }

  // Collects the speck at a pixel. @return the label of the only region that it touches; 0 if there is none or several.
  std::int32_t collect(int first) {
    std::int32_t around = 0;
    bool alone = true;
    const auto visit = [&](int i) {
      if (!grid_.valid(i)) return;
      if (loose_[labels_[i]] == 0) {
        alone = alone && (around == 0 || around == labels_[i]);
        around = labels_[i];
      } else if (seen_[i] == 0) {
        seen_[i] = 1;
        speck_.push_back(i);
      }
    };
    speck_.assign(1, first);
    seen_[first] = 1;
    std::size_t next = 0;
    while (next < speck_.size()) {
      const int i = speck_[next++], row = i / grid_.cols, col = i % grid_.cols;
      if (col > 0) visit(i - 1);
      if (col + 1 < grid_.cols) visit(i + 1);
      if (row > 0) visit(i - grid_.cols);
      if (row + 1 < grid_.rows) visit(i + grid_.cols);
    }
    return alone ? around : 0;
  }

  // Whether the speck lies on a plane as well as noise lets it.
  bool belongs(const Eigen::Vector3d& a) const {
    double sum = 0.0, squares = 0.0, variances = 0.0, allowed = 0.0;
    for (const int i : speck_) {
      const double along = a.dot(grid_.direction(i).cast<double>());
      const double across = 1.0 + a.dot(center_) - a.dot(grid_.origin(i).cast<double>());
      const double distance = grid_.range[i] - across / along;
      const double sigma = noise_.sigma(grid_.range[i]), floor = tolerance_.forNoise(sigma).sigma_distance;
      const double tolerated = floor * floor * std::min(kMaxSecant2, a.squaredNorm() / (along * along));
      sum += distance;
      squares += distance * distance / (sigma * sigma + tolerated);
      variances += sigma * sigma;
      allowed += tolerated;
    }
    const auto n = static_cast<double>(speck_.size());
    const double deviation = std::sqrt(variances / n * std::min(1.0, tolerance_.inflationOf(n) / n) + allowed / n);
    return std::abs(sum / n) <= kMaxMean * deviation && squares / n <= kMaxScatter;  // not if the plane is seen edge-on
  }

  const BeamGrid& grid_;
  const std::vector<Eigen::Vector3d>& planes_;
  const Eigen::Vector3d& center_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  std::vector<std::int32_t>& labels_;
  std::vector<char>& loose_;
  std::vector<char>& seen_;
  std::vector<int>& speck_;
};

}  // namespace

void fillHoles(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, HoleMemory& memory,
               LabelImage& labels) {
  HoleFiller(grid, planes, center, noise, tolerance, smallest, memory, labels).fillAll();
}

void fillHoles(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, LabelImage& labels) {
  HoleMemory memory;
  fillHoles(grid, planes, center, noise, tolerance, smallest, memory, labels);
}

}  // namespace ppc
