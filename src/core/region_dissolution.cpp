// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_dissolution.h"

#include "patch_plane_clustering/core/beam_planes.h"
#include "patch_plane_clustering/core/fullest_lines.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kLargest = 16;          // times the smallest region: what is larger is no trace of an edge
constexpr double kMostInside = 0.7;   // share of the points that touch nothing else
constexpr double kLeastTouch = 0.05;  // share of what a region touches that makes another one a neighbour
constexpr int kSample = 100;          // points that are looked at first
constexpr int kBumpSample = 1000;     // points of a bump and of what is beside it
constexpr double kExplained = 0.9;    // times what its own plane costs: what planes around may cost
constexpr double kClearly = 2.0;      // times what its own plane costs: not explained, as few points tell
constexpr double kBump = 3.0;         // times what a plane costs its own points: what it may cost those of a bump of it
constexpr double kMostOfHost = 2.0;   // cost of such a plane's own points that counts: of what fits worse, little is known
constexpr int kHostSizes = 4;         // least size of such a plane over the bump's
constexpr double kOfLines = 0.875;    // share of the points that makes the lines that have most of them the whole
constexpr double kSizesOfTwo = 5.0 / 3.0;  // least size of a region of two lines over the smallest,
constexpr double kFewestOfTwo = 100.0;     // but no more points
constexpr double kOfTwo = 1.5;             // what planes around may cost a point of such a region [variances]
constexpr float kFarthest2 = 25.0F;        // squared distance at which a point is an outlier, in variances
constexpr float kFarthestOf2 = 9.0F;       // and at which it is not of a plane

using Region = RegionStretches::Region;

class Dissolver {
 public:
  Dissolver(const JudgedImage& image, const BeamPlanes& planes, DissolutionMemory& memory, LabelImage& labels,
            std::vector<LabelRun>& runs, int threads)
      : grid_(image.grid),
        planes_(planes),
        smallest_(image.smallest),
        memory_(memory),
        labels_(labels),
        runs_(runs),
        threads_(threads) {}

  /// @param correlated whether noise makes bumps.
  void dissolveAll(bool correlated) {
    countPoints(runs_, planes_.size(), memory_.points);
    listJudged(correlated);
    memory_.touches.assign(planes_.size(), 0);
    memory_.mean_costs.assign(planes_.size(), -1.0F);
    // Explained by all that is around; but what is none itself is given nothing.
    std::vector<DissolvedRegion>& dissolved = memory_.dissolved;
    dissolved.clear();
    for (const Region& region : memory_.judged.regions) {
      const bool thin = isThin(region.label), few = mayBeLines(region.label);
      if (!thin && !few && !correlated) continue;
      lookAt(region);
      const bool lines = few && isLines(region.label);
      if (lines || (thin && isExplained(region.label)) || (correlated && isBump(region.label))) {
        dissolved.push_back({region, lines});
      }
    }
    for (const DissolvedRegion& region : dissolved) memory_.points[region.region.label] = 0;
    // Those that explain each other stay; found before labels change, so that no order of them decides.
    const auto unexplained = [&](const DissolvedRegion& region) {
      lookAt(region.region);
      return memory_.around.empty() && !region.lines;
    };
    dissolved.erase(std::remove_if(dissolved.begin(), dissolved.end(), unexplained), dissolved.end());
    for (const auto& [region, lines] : dissolved) {
      lookAt(region);
      if (memory_.around.empty()) {
        for (const int i : memory_.pixels) labels_.labels[i] = 0;
      } else {
        measure(region.label, memory_.pixels.size());
        giveAway(region.label, lines);
      }
    }
    if (!dissolved.empty()) listRuns(labels_, memory_.listing, runs_, threads_);
  }

 private:
  bool isJudged(std::int32_t label) const {
    return memory_.points[label] >= smallest_ && memory_.points[label] / kLargest < smallest_;
  }

  bool isThin(std::int32_t label) const {
    return isJudged(label) && memory_.inside[label] < kMostInside * memory_.points[label];
  }

  // Calls f(pixel) for a pixel and those next to it, corners too, row by row.
  template <typename F>
  void forEachAbout(int i, F&& f) const {
    const int row = i / grid_.cols, col = i % grid_.cols;
    const int top = std::max(row - 1, 0), bottom = std::min(row + 1, grid_.rows - 1);
    const int left = std::max(col - 1, 0), right = std::min(col + 1, grid_.cols - 1);
    for (int r = top; r <= bottom; ++r) {
      for (int j = grid_.index(r, left); j <= grid_.index(r, right); ++j) f(j);
    }
  }

  // Whether no pixel around has a measurement and another label.
  bool isInside(int i) const {
    const std::int32_t label = labels_.labels[i];
    bool inside = true;
    forEachAbout(i, [&](int j) { inside = inside && (labels_.labels[j] == label || !grid_.valid(j)); });
    return inside;
  }

  // Pixels of a run about which there are none of another label; not those next to the ends of the image.
  int countSurelyInside(const LabelRun& run) const {
    const int first = std::max(run.begin + 1, grid_.cols + 1);
    const int last = std::min(run.end - 1, grid_.size() - grid_.cols - 1 - kLanes);
    const LaneMask label = fillMask(run.label);
    const std::int32_t* const pixels = labels_.labels.data();
    const auto same_beside = [&](int i) {
      return (loadLanes<LaneMask>(pixels + i - 1) == label) & (loadLanes<LaneMask>(pixels + i) == label) &
             (loadLanes<LaneMask>(pixels + i + 1) == label);
    };
    LaneMask inside{};
    for (int i = first; i < last; i += kLanes) {
      inside += firstLanes(last - i) & same_beside(i - grid_.cols) & same_beside(i + grid_.cols);
    }
    return countLanes(inside);
  }

  int countInside(const Region& region) const {
    int count = 0;
    for (std::size_t s = region.begin; s < region.end; ++s) {
      const PixelStretch& stretch = memory_.judged.stretches[s];
      for (int i = stretch.begin; i < stretch.end; ++i) count += isInside(i) ? 1 : 0;
    }
    return count;
  }

  // Lists regions that may be thin or, if `all`, also those that are not.
  void listJudged(bool all) {
    std::vector<int>& inside = memory_.inside;
    inside.assign(planes_.size(), 0);
    std::vector<int>& run_inside = memory_.run_inside;
    run_inside.resize(runs_.size());
    forEachRange(threads_, static_cast<int>(runs_.size()), [&](int begin, int end) {
      for (int k = begin; k < end; ++k) run_inside[k] = isJudged(runs_[k].label) ? countSurelyInside(runs_[k]) : 0;
    });
    for (std::size_t k = 0; k < runs_.size(); ++k) inside[runs_[k].label] += run_inside[k];
    RegionStretches& judged = memory_.judged;
    judged.list(runs_, planes_.size(), [&](std::int32_t label) { return all ? isJudged(label) : isThin(label); });
    forEachPart(threads_, static_cast<int>(judged.regions.size()), [&](int k) {
      const Region& region = judged.regions[k];
      if (isThin(region.label)) inside[region.label] = countInside(region);
    });
  }

  // Lists the points of a region, and what is around it.
  void lookAt(const Region& region) {
    memory_.pixels.clear();
    for (std::size_t s = region.begin; s < region.end; ++s) {
      const PixelStretch& stretch = memory_.judged.stretches[s];
      for (int i = stretch.begin; i < stretch.end; ++i) {
        if (grid_.valid(i)) memory_.pixels.push_back(i);
      }
    }
    listAround(region.label);
  }

  void listAround(std::int32_t label) {
    std::vector<std::int32_t>& around = memory_.around;
    around.clear();
    int all = 0;
    const auto touch = [&](int i) {
      const std::int32_t other = labels_.labels[i];
      if (other == label || !grid_.valid(i)) return;
      ++all;
      if (other == 0 || memory_.points[other] < smallest_) return;
      if (memory_.touches[other]++ == 0) around.push_back(other);
    };
    for (const int i : memory_.pixels) {
      const int row = i / grid_.cols, col = i % grid_.cols;
      for (int step = 1; step <= 2; ++step) {
        if (col >= step) touch(i - step);
        if (col + step < grid_.cols) touch(i + step);
        if (row >= step) touch(i - step * grid_.cols);
        if (row + step < grid_.rows) touch(i + step * grid_.cols);
      }
    }
    std::size_t kept = 0;
    for (const std::int32_t other : around) {
      if (memory_.touches[other] >= kLeastTouch * all) around[kept++] = other;
      memory_.touches[other] = 0;
    }
    around.resize(kept);
    std::sort(around.begin(), around.end());
  }

  // Squared distance of a point from a plane along its beam, in variances of noise and tolerance; capped.
  float cost(int i, std::int32_t label, double variance) const {
    const auto [along, across] = planes_.meet(i, label);
    const double missed = grid_.range[i] * along - across;
    if (!(across * along > 0.0)) return kFarthest2;  // the beam does not meet it
    return static_cast<float>(std::min<double>(kFarthest2, missed * missed / (variance * along * along)));
  }

  // What points cost for their own plane, and for the nearest one around.
  struct Costs {
    double own = 0.0, others = 0.0;
  };

  // @param wanted of the points; all others are skipped, evenly.
  Costs measure(std::int32_t label, std::size_t wanted) {
    const std::vector<std::int32_t>& around = memory_.around;
    const std::size_t step = std::max<std::size_t>(1, memory_.pixels.size() / std::max<std::size_t>(1, wanted));
    memory_.costs.clear();
    Costs sums;
    for (std::size_t p = 0; p < memory_.pixels.size(); p += step) {
      const int i = memory_.pixels[p];
      const auto [sigma, floor] = planes_.errorsAt(i);
      const double variance = sigma * sigma + floor * floor;
      memory_.costs.push_back(cost(i, label, variance));
      sums.own += memory_.costs.back();
      float least = kFarthest2;
      for (const std::int32_t other : around) {
        memory_.costs.push_back(cost(i, other, variance));
        least = std::min(least, memory_.costs.back());
      }
      sums.others += least;
    }
    return sums;
  }

  // Most faces are clearly none of this: a few points tell.
  bool isExplained(std::int32_t label) {
    const auto costs_less = [&](std::size_t wanted, double factor) {
      const Costs costs = measure(label, wanted);
      return costs.others < factor * costs.own;
    };
    return !memory_.around.empty() && costs_less(kSample, kClearly) && costs_less(memory_.pixels.size(), kExplained);
  }

  // Whether a region has so few points that two lines of the image may hold them.
  bool mayBeLines(std::int32_t label) const {
    return kOfLines * memory_.points[label] <= 2.0 * std::max(grid_.rows, grid_.cols);
  }

  // Whether a region is a line of pixels, or two that may be of two faces as well.
  bool isLines(std::int32_t label) {
    const std::size_t points = memory_.pixels.size();
    const FullestLines rows = fullestLines(
        memory_.pixels, grid_.rows, [&](int i) { return i / grid_.cols; }, memory_.in_line);
    const FullestLines cols = fullestLines(
        memory_.pixels, grid_.cols, [&](int i) { return i % grid_.cols; }, memory_.in_line);
    const double whole = kOfLines * static_cast<double>(points);
    if (std::max(rows.one, cols.one) > whole) return true;
    if (std::max(rows.two, cols.two) <= whole) return false;
    return static_cast<double>(points) < std::min(kFewestOfTwo, kSizesOfTwo * smallest_) ||
           (!memory_.around.empty() && measure(label, points).others < kOfTwo * static_cast<double>(points));
  }

  // Whether a region is a bump of smooth noise on a much larger one beside it, which itself stays: hardly farther from that
  // one's plane than its own points are.
  bool isBump(std::int32_t label) {
    for (const std::int32_t host : memory_.around) {
      if (isJudged(host) || memory_.points[host] < kHostSizes * memory_.points[label]) continue;
      double sum = 0.0;
      const std::size_t step = std::max<std::size_t>(1, memory_.pixels.size() / kBumpSample);
      int count = 0;
      for (std::size_t p = 0; p < memory_.pixels.size(); p += step, ++count) sum += cost(memory_.pixels[p], host);
      float& of_host = memory_.mean_costs[host];
      if (of_host < 0.0F) of_host = static_cast<float>(meanCost(host));
      if (sum < kBump * count * std::min<double>(of_host, kMostOfHost)) return true;
    }
    return false;
  }

  // What a plane costs its own points, a sample of them.
  double meanCost(std::int32_t label) const {
    const int step = std::max(1, memory_.points[label] / kBumpSample);
    double sum = 0.0;
    int count = 0, next = 0;
    for (const LabelRun& run : runs_) {
      if (run.label != label) continue;
      int i = run.begin + next;
      for (; i < run.end; i += step) {
        if (!grid_.valid(i)) continue;
        sum += cost(i, label);
        ++count;
      }
      next = i - run.end;
    }
    return sum / std::max(1, count);
  }

  float cost(int i, std::int32_t label) const {
    const auto [sigma, floor] = planes_.errorsAt(i);
    return cost(i, label, sigma * sigma + floor * floor);
  }

  // @param one_by_one each point by itself: those about it may be of other faces.
  void giveAway(std::int32_t label, bool one_by_one) {
    const std::vector<int>& pixels = memory_.pixels;
    const std::size_t count = memory_.around.size() + 1;
    memory_.place.resize(static_cast<std::size_t>(grid_.size()));
    for (std::size_t p = 0; p < pixels.size(); ++p) memory_.place[pixels[p]] = static_cast<int>(p);
    memory_.given.resize(pixels.size());
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      std::size_t best = 1;
      float least = 0.0F;
      for (std::size_t k = 1; k < count; ++k) {
        const float sum = one_by_one ? memory_.costs[p * count + k] : sumAround(pixels[p], label, k, count);
        if (k > 1 && sum >= least) continue;
        best = k;
        least = sum;
      }
      const bool near = memory_.costs[p * count + best] < kFarthestOf2;
      memory_.given[p] = near ? memory_.around[best - 1] : 0;
    }
    for (std::size_t p = 0; p < pixels.size(); ++p) labels_.labels[pixels[p]] = memory_.given[p];
  }

  // Costs of a plane at the region's pixels about one of them.
  float sumAround(int i, std::int32_t label, std::size_t k, std::size_t count) const {
    float sum = 0.0F;
    forEachAbout(i, [&](int j) {
      if (labels_.labels[j] != label || !grid_.valid(j)) return;
      sum += std::min(kFarthestOf2, memory_.costs[static_cast<std::size_t>(memory_.place[j]) * count + k]);
    });
    return sum;
  }

  const BeamGrid& grid_;
  const BeamPlanes& planes_;
  int smallest_;
  DissolutionMemory& memory_;
  LabelImage& labels_;
  std::vector<LabelRun>& runs_;
  int threads_;
};

}  // namespace

void dissolveRegions(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, DissolutionMemory& memory,
                     LabelImage& labels, std::vector<LabelRun>& runs, int threads) {
  Dissolver(image, BeamPlanes(image, planes), memory, labels, runs, threads).dissolveAll(image.tolerance.isSmooth());
}

}  // namespace ppc
