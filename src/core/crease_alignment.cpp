// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_alignment.h"

#include "patch_plane_clustering/core/crease_lanes.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace ppc {
namespace {

using LabelPair = CreaseMemory::LabelPair;
using Worker = CreaseMemory::Worker;
using Change = CreaseMemory::Change;

constexpr int kReach = 6;                // pixels from a border that are looked at
constexpr float kClearlyApart = 1.0F;    // distance of two planes that tells on which side one is seen, in sigmas
constexpr float kWithinNoise = 1.5F;     // distance of two planes at which a point may be of either, in sigmas
constexpr float kFarthestPoint = 2.5F;   // of a point from the plane that it is given to, in sigmas
constexpr int kFewestWitnesses = 5;      // points at which planes are clearly apart
constexpr double kLeastAgreement = 0.8;  // of the witnesses

// Lists where labels of at least `smallest` points meet, pair by pair.
class MeetingFinder {
 public:
  MeetingFinder(const LabelImage& labels, int smallest, CreaseMemory& memory)
      : labels_(labels), smallest_(smallest), memory_(memory) {}

  void find(std::size_t labels) {
    memory_.points.assign(labels, 0);
    memory_.pairs.clear();
    memory_.meetings.clear();
    for (int r = 0; r < labels_.rows; ++r) {
      listAlongRow(r);
      if (r > 0) forEachChangeFromAbove(labels_, r, [&](int pixel) { meet(pixel, labels_.cols); });
    }
    groupByPair();
  }

 private:
  // Counts the points of the row's labels on the way.
  void listAlongRow(int r) {
    const int row = r * labels_.cols;
    const std::int32_t* const pixels = labels_.labels.data() + row;
    for (int begin = 0, end = 0; begin < labels_.cols; begin = end) {
      end = runEnd(pixels, begin, labels_.cols);
      if (pixels[begin] > 0) memory_.points[pixels[begin]] += end - begin;
      if (begin > 0) meet(row + begin, 1);
    }
  }

  void meet(int pixel, int step) {
    const std::int32_t a = labels_.labels[pixel - step], b = labels_.labels[pixel];
    if (a <= 0 || b <= 0) return;
    LabelPair& pair = pairOf(std::min(a, b), std::max(a, b));
    ++pair.meetings;
    memory_.meetings.push_back({pair.index, {pixel, step}});
  }

  // Only pairs whose regions are large enough remain.
  void groupByPair() {
    std::vector<LabelPair>& pairs = memory_.pairs;
    memory_.next.assign(pairs.size(), -1);
    const auto small = [&](const LabelPair& pair) {
      return memory_.points[pair.first] < smallest_ || memory_.points[pair.second] < smallest_;
    };
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), small), pairs.end());
    int begin = 0;
    for (LabelPair& pair : pairs) {
      memory_.next[pair.index] = pair.begin = begin;
      begin += pair.meetings;
    }
    memory_.places.resize(static_cast<std::size_t>(begin));
    for (const CreaseMemory::Meeting& meeting : memory_.meetings) {
      int& next = memory_.next[meeting.pair];
      if (next >= 0) memory_.places[next++] = meeting.place;
    }
  }

  LabelPair& pairOf(std::int32_t first, std::int32_t second) {
    std::vector<LabelPair>& pairs = memory_.pairs;
    if (last_ < pairs.size() && pairs[last_].first == first && pairs[last_].second == second) return pairs[last_];
    const auto before = [](const LabelPair& a, const LabelPair& b) {
      return std::tie(a.first, a.second) < std::tie(b.first, b.second);
    };
    const LabelPair fresh{first, second, static_cast<int>(pairs.size()), 0, 0};
    auto at = std::lower_bound(pairs.begin(), pairs.end(), fresh, before);
    if (at == pairs.end() || before(fresh, *at)) at = pairs.insert(at, fresh);
    last_ = static_cast<std::size_t>(at - pairs.begin());
    return *at;
  }

  const LabelImage& labels_;
  int smallest_;
  CreaseMemory& memory_;
  std::size_t last_ = 0;  // borders are long: most meetings are of the pair of the one before
};

class CreaseAligner {
 public:
  CreaseAligner(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
                const NoiseModel& noise, const CoplanarityTolerance& tolerance, const LabelImage& labels)
      : grid_(grid), planes_(planes), center_(center), noise_(noise), tolerance_(tolerance), labels_(labels.labels.data()) {}

  // Lists what is to change between two labels that meet at `places`.
  void align(const LabelPair& pair, const CreaseMemory::Place* places, Worker& worker, std::vector<Change>& changes) const {
    changes.clear();
    lookAround(pair, places, worker);
    int witnesses = 0, farther = 0;  // those of them that are of the farther plane, as at the edge of a box
    compare(pair, worker, witnesses, farther);
    if (std::max(farther, witnesses - farther) < std::max<double>(kFewestWitnesses, kLeastAgreement * witnesses)) return;
    const bool farther_is_seen = 2 * farther > witnesses;
    for (const CreaseMemory::Candidate& candidate : worker.open) {
      const std::int32_t label = candidate.first_farther == farther_is_seen ? pair.first : pair.second;
      if (label != labels_[candidate.pixel]) changes.push_back({candidate.pixel, label});
    }
  }

 private:
  // Lists the pixels on both sides of the meetings, as far as they are of either label.
  void lookAround(const LabelPair& pair, const CreaseMemory::Place* places, Worker& worker) const {
    const auto size = static_cast<std::size_t>(grid_.size());
    if (worker.seen.size() != size || worker.stamp == std::numeric_limits<int>::max()) {
      worker.seen.assign(size, 0);
      worker.stamp = 0;
    }
    const int stamp = ++worker.stamp;
    int* const seen = worker.seen.data();
    const std::int32_t first = pair.first, second = pair.second;
    // Room for all of them, so that none has to ask for it.
    const std::size_t most = std::min(size, static_cast<std::size_t>(pair.meetings) * 2 * kReach) + 1;
    if (worker.near.size() < most) worker.near.resize(most);
    int* next = worker.near.data();
    const auto walk = [&](int pixel, int step, int count) {
      for (int k = 0; k < count; ++k, pixel += step) {
        if (labels_[pixel] != first && labels_[pixel] != second) return;
        *next = pixel;
        next += seen[pixel] != stamp ? 1 : 0;
        seen[pixel] = stamp;
      }
    };
    for (int m = 0; m < pair.meetings; ++m) {
      const auto [pixel, step] = places[m];
      const int place = step == 1 ? pixel % grid_.cols : pixel / grid_.cols;
      walk(pixel - step, -step, std::min(kReach, place));
      walk(pixel, step, std::min(kReach, (step == 1 ? grid_.cols : grid_.rows) - place));
    }
    worker.count = static_cast<int>(next - worker.near.data());
  }

  // Compares both planes at the pixels near a border, four at a time.
  void compare(const LabelPair& pair, Worker& worker, int& witnesses, int& farther) const {
    const CreaseLanes planes(planes_[pair.first], planes_[pair.second], center_);
    worker.open.clear();
    LaneMask apart = {}, of_farther = {};
    for (int begin = 0; begin < worker.count; begin += kLanes) {
      int pixels[kLanes];
      LaneMask of_first;
      Lanes variance;
      for (int k = 0; k < kLanes; ++k) {
        pixels[k] = worker.near[begin + k < worker.count ? begin + k : begin];
        of_first[k] = labels_[pixels[k]] == pair.first ? -1 : 0;
        variance[k] = static_cast<float>(varianceAt(pixels[k]));
      }
      const BeamLanes beams(grid_, pixels, firstLanes(worker.count - begin));
      const auto found = planes.compare(beams, variance, of_first, kClearlyApart, kWithinNoise, kFarthestPoint);
      apart += found.apart;
      of_farther += found.apart & ~(of_first ^ found.first_farther);
      if (!anyLane(found.open)) continue;
      for (int k = 0; k < kLanes; ++k) {
        if (found.open[k] != 0) worker.open.push_back({pixels[k], found.first_farther[k] != 0});
      }
    }
    witnesses = countLanes(apart);
    farther = countLanes(of_farther);
  }

  // Of distances along a beam: noise, and what planes are allowed [m^2].
  double varianceAt(int pixel) const {
    const double noise = noise_.sigma(grid_.valid(pixel) ? grid_.range[pixel] : 0.0F);
    const double floor = tolerance_.forNoise(noise).sigma_distance;
    return noise * noise + floor * floor;
  }

  const BeamGrid& grid_;
  const std::vector<Eigen::Vector3d>& planes_;
  const Eigen::Vector3d& center_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  const std::int32_t* labels_;
};

}  // namespace

void alignCreases(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
                  const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, CreaseMemory& memory,
                  LabelImage& labels, int threads) {
  MeetingFinder(labels, smallest, memory).find(planes.size());
  const std::vector<LabelPair>& pairs = memory.pairs;
  if (memory.changes.size() < pairs.size()) memory.changes.resize(pairs.size());
  const CreaseAligner aligner(grid, planes, center, noise, tolerance, labels);
  forEachPart(threads, static_cast<int>(pairs.size()), memory.workers, [&](int k, Worker& worker) {
    aligner.align(pairs[k], memory.places.data() + pairs[k].begin, worker, memory.changes[k]);
  });
  // Not before all pairs are known, and in their order: a pixel may be near several borders.
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (const Change& change : memory.changes[k]) labels.labels[change.pixel] = change.label;
  }
}

}  // namespace ppc
