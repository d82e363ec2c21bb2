// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/hole_filling.h"

#include "patch_plane_clustering/core/beam_planes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

constexpr double kMaxMean = 4.0;     // mean distance of a speck, in standard deviations of such a mean
constexpr double kMaxScatter = 6.0;  // mean square of its distances, in variances of noise and tolerance

// Lists the runs of pixels [begin, end), and counts those of each label.
void listPart(const std::vector<std::int32_t>& labels, int begin, int end, std::size_t count, HoleMemory::Part& part) {
  part.runs.clear();
  part.points.assign(count, 0);
  for (int at = begin, run_end = 0; at < end; at = run_end) {
    run_end = runEnd(labels.data(), at, end);
    part.runs.push_back({labels[at], at, run_end});
    part.points[labels[at]] += run_end - at;
  }
}

class HoleFiller {
 public:
  HoleFiller(const BeamGrid& grid, const BeamPlanes& planes, const CoplanarityTolerance& tolerance, int smallest,
             HoleMemory& memory, LabelImage& labels)
      : grid_(grid),
        planes_(planes),
        tolerance_(tolerance),
        smallest_(smallest),
        labels_(labels.labels),
        parts_(memory.parts),
        loose_(memory.loose),
        seen_(memory.seen),
        speck_(memory.speck) {}

  void listRuns(int threads) {
    const int parts = rangeCount(threads, grid_.size());
    parts_.resize(static_cast<std::size_t>(parts));
    seen_.resize(static_cast<std::size_t>(grid_.size()));
    forEachPart(threads, parts, [&](int k) {
      const int begin = partBegin(grid_.size(), parts, k), end = partBegin(grid_.size(), parts, k + 1);
      listPart(labels_, begin, end, planes_.size(), parts_[k]);
      std::fill(seen_.begin() + begin, seen_.begin() + end, 0);
    });
    loose_.resize(planes_.size());
    for (std::size_t label = 0; label < loose_.size(); ++label) {
      int points = 0;
      for (const HoleMemory::Part& part : parts_) points += part.points[label];
      loose_[label] = label == 0 || points < smallest_ ? 1 : 0;
    }
  }

  // Runs are those before anything was filled: what has been since was seen.
  void fillAll() {
    for (const HoleMemory::Part& part : parts_) {
      for (const LabelRun& run : part.runs) {
        if (loose_[run.label] == 0) continue;
        for (int i = run.begin; i < run.end; ++i) {
          if (seen_[i] == 0 && grid_.valid(i)) fillFrom(i);
        }
      }
    }
  }

 private:
  void fillFrom(int first) {
    const std::int32_t around = collect(first);
    if (around == 0 || static_cast<int>(speck_.size()) >= smallest_ || !belongs(around)) return;
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
  bool belongs(std::int32_t label) const {
    const double a2 = planes_.of(label).squaredNorm();
    double sum = 0.0, squares = 0.0, variances = 0.0, allowed = 0.0;
    for (const int i : speck_) {
      const BeamPlanes::Meeting met = planes_.meet(i, label);
      const BeamPlanes::Errors errors = planes_.errorsAt(i);
      const double distance = grid_.range[i] - met.across / met.along;
      const double tolerated = errors.floor * errors.floor * std::min(kMaxSecant2, a2 / (met.along * met.along));
      sum += distance;
      squares += distance * distance / (errors.sigma * errors.sigma + tolerated);
      variances += errors.sigma * errors.sigma;
      allowed += tolerated;
    }
    const auto n = static_cast<double>(speck_.size());
    const double deviation = std::sqrt(variances / n * std::min(1.0, tolerance_.inflationOf(n) / n) + allowed / n);
    return std::abs(sum / n) <= kMaxMean * deviation && squares / n <= kMaxScatter;  // not if the plane is seen edge-on
  }

  const BeamGrid& grid_;
  const BeamPlanes& planes_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  std::vector<std::int32_t>& labels_;
  std::vector<HoleMemory::Part>& parts_;
  std::vector<char>& loose_;
  std::vector<char>& seen_;
  std::vector<int>& speck_;
};

}  // namespace

void fillHoles(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, HoleMemory& memory,
               LabelImage& labels, int threads) {
  const BeamPlanes of_labels(grid, planes, center, noise, tolerance);
  HoleFiller filler(grid, of_labels, tolerance, smallest, memory, labels);
  filler.listRuns(threads);
  filler.fillAll();
}

void fillHoles(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, LabelImage& labels) {
  HoleMemory memory;
  fillHoles(grid, planes, center, noise, tolerance, smallest, memory, labels);
}

}  // namespace ppc
