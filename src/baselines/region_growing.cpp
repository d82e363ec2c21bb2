// SPDX-License-Identifier: BSD-3-Clause
#include "local_fits.h"
#include "methods.h"
#include "patch_plane_clustering/core/stage_timer.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace ppc {
namespace {

constexpr int kSeedHalfWindow = 4;     // [columns]
constexpr double kRefitGrowth = 1.03;  // the plane is fitted anew when the region has grown by this factor

struct Limits {
  double point_distance;
  double mean_square_error;
};

struct Candidate {
  float distance;  // from the seed [m]: a region that grows as a disc soon has a well-conditioned plane
  int pixel;
  int parent;
  bool operator<(const Candidate& other) const {  // nearest first; ties in image order
    return distance != other.distance ? distance > other.distance : pixel > other.pixel;
  }
};

class Growing {
 public:
  Growing(const BeamGrid& grid, const Config& config, const Limits& limits)
      : grid_(grid), config_(config), limits_(limits), noise_(noiseOf(grid, config)) {
    labels_ = {grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
    visited_.assign(labels_.labels.size(), 0);
  }

  LabelImage run(StageTimer& timer) {
    const std::vector<int> seeds = orderedSeeds();
    timer.lap("seeds");
    for (const int seed : seeds) {
      if (labels_.labels[seed] == 0 && tried_[seed] == 0) grow(seed);
    }
    timer.lap("growing");
    return std::move(labels_);
  }

 private:
  // The systematic part of the error does not shrink with the noise.
  double sigmaAt(int i) const { return std::hypot(noise_.sigma(grid_.range[i]), config_.sigma_distance); }

  // Every third pixel each way, flattest first.
  std::vector<int> orderedSeeds() {
    window_ = windowOf(grid_, kSeedHalfWindow);
    tried_.assign(labels_.labels.size(), 0);
    std::vector<std::pair<float, int>> order;
    for (int r = 1; r < grid_.rows; r += 3) {
      for (int c = 1; c < grid_.cols; c += 3) {
        const int i = grid_.index(r, c);
        if (!grid_.valid(i)) continue;
        const double sigma = sigmaAt(i);
        const PointSums sums = windowSums(grid_, i, window_, gapAt(grid_.range[i], sigma));
        if (sums.n < 6) continue;
        const double flatness = fitPlane(sums).mean_square / (sigma * sigma);
        if (flatness < limits_.mean_square_error) order.emplace_back(static_cast<float>(flatness), i);
      }
    }
    std::sort(order.begin(), order.end());
    std::vector<int> seeds;
    seeds.reserve(order.size());
    for (const auto& each : order) seeds.push_back(each.second);
    return seeds;
  }

  void enqueueNeighbours(int i) {
    const int row = i / grid_.cols, col = i % grid_.cols;
    const auto offer = [&](int j) {
      if (visited_[j] == pass_ || labels_.labels[j] != 0 || !grid_.valid(j)) return;
      queue_.push({(grid_.point(j) - seed_).norm(), j, i});
    };
    if (row > 0) offer(i - grid_.cols);
    if (row + 1 < grid_.rows) offer(i + grid_.cols);
    if (col > 0) offer(i - 1);
    if (col + 1 < grid_.cols) offer(i + 1);
  }

  void grow(int seed) {
    ++pass_;
    queue_ = {};
    members_.clear();
    sums_ = {};
    local_ = fitPlane(windowSums(grid_, seed, window_, gapAt(grid_.range[seed], sigmaAt(seed))));
    seed_ = grid_.point(seed);
    take(seed);
    int next_fit = 12;
    double square = 0.0;  // sum of squared distances, in sigmas
    while (!queue_.empty()) {
      const Candidate candidate = queue_.top();
      queue_.pop();
      const int i = candidate.pixel;
      if (visited_[i] == pass_) continue;
      const double sigma = sigmaAt(i);
      const double distance = local_.plane.signedDistance(grid_.point(i).cast<double>()) / sigma;
      if (std::abs(distance) > limits_.point_distance) continue;
      if (std::abs(grid_.range[i] - grid_.range[candidate.parent]) > gapAt(grid_.range[i], sigma)) continue;
      const double error = (square + distance * distance) / (sums_.n + 1.0);
      if (sums_.n > 50 && error > limits_.mean_square_error) continue;
      square += distance * distance;
      take(i);
      if (sums_.n < next_fit) continue;
      local_ = fitPlane(sums_);
      square = sums_.n * local_.mean_square / (sigma * sigma);
      next_fit = std::max(sums_.n + 6, static_cast<int>(sums_.n * kRefitGrowth));
    }
    const bool large = sums_.n >= smallestRegion(config_, grid_.size());
    if (large) ++regions_;
    for (const int i : members_) {
      tried_[i] = 1;
      if (large) labels_.labels[i] = regions_;
    }
  }

  void take(int i) {
    visited_[i] = pass_;
    members_.push_back(i);
    sums_.add(grid_.point(i).cast<double>());
    enqueueNeighbours(i);
  }

  const BeamGrid& grid_;
  const Config& config_;
  Limits limits_;
  NoiseModel noise_;
  Window window_;
  LabelImage labels_;
  std::vector<char> tried_;   // was in a region that stayed too small: no seed again
  std::vector<int> visited_;  // pass in which the pixel joined
  int pass_ = 0;
  int regions_ = 0;
  std::priority_queue<Candidate> queue_;
  std::vector<int> members_;
  PointSums sums_;
  LocalPlane local_;
  Eigen::Vector3f seed_;
};

class RegionGrowing : public PlaneSegmenter {
 public:
  // Defaults: the best at the data sheet's noise in scripts/tune_baselines.py.
  RegionGrowing()
      : PlaneSegmenter({{"point_distance", 2.0, 0.5, 20.0, "largest distance of a point from the plane [sigmas]"},
                        {"mean_square_error", 1.2, 0.1, 100.0, "largest of a region [sigmas squared]"}}) {}

  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    StageTimer timer(stages);
    return Growing(grid, config, {parameter("point_distance"), parameter("mean_square_error")}).run(timer);
  }
};

}  // namespace

std::unique_ptr<PlaneSegmenter> makeRegionGrowing() { return std::make_unique<RegionGrowing>(); }

}  // namespace ppc
