// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_alignment.h"

#include "patch_plane_clustering/core/crease_band.h"
#include "patch_plane_clustering/core/crease_lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <utility>

namespace ppc {
namespace {

using Pair = CreaseMeetings::Pair;
using Worker = CreaseMemory::Worker;
using Change = CreaseMemory::Change;

constexpr int kReach = 6;                // pixels from a border that are looked at
constexpr float kClearlyApart = 1.0F;    // distance of two planes that tells on which side one is seen, in sigmas
constexpr float kWithinNoise = 1.5F;     // distance of two planes at which a point may be of either, in sigmas
constexpr float kFarthestPoint = 2.5F;   // of a point from the plane that it is given to, in sigmas
constexpr int kFewestWitnesses = 5;      // points at which planes are clearly apart
constexpr double kLeastAgreement = 0.8;  // of the witnesses

class CreaseAligner {
 public:
  CreaseAligner(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, const DistanceVariance& variance,
                const CreaseMeetings& meetings, const LabelImage& labels)
      : grid_(image.grid),
        planes_(planes),
        center_(image.center),
        variance_(variance),
        meetings_(meetings),
        labels_(labels) {}

  // Lists what is to change between two labels.
  void align(const Pair& pair, Worker& worker, std::vector<Change>& changes) const {
    changes.clear();
    lookAround(pair, worker);
    int witnesses = 0, farther = 0;  // those of them that are of the farther plane, as at the edge of a box
    compare(pair, worker, witnesses, farther);
    if (std::max(farther, witnesses - farther) < std::max<double>(kFewestWitnesses, kLeastAgreement * witnesses)) return;
    const bool farther_is_seen = 2 * farther > witnesses;
    for (const CreaseMemory::Candidate& candidate : worker.open) {
      const std::int32_t label = candidate.first_farther == farther_is_seen ? pair.first : pair.second;
      if (label != labels_.labels[candidate.pixel]) changes.push_back({candidate.pixel, label});
    }
  }

 private:
  // Collects the pixels on both sides of the meetings, as far as they are of either label.
  void lookAround(const Pair& pair, Worker& worker) const {
    worker.near.resize(grid_.size());
    CreaseBand band(labels_, pair.first, pair.second, kReach, worker.near);
    for (int m = pair.begin; m < pair.end; ++m) {
      const auto [pixel, columns] = meetings_.places[m];
      if (columns == 0) {
        band.addAlongRow(pixel);
      } else {
        band.addAlongColumns(pixel, columns);
      }
    }
  }

  // Compares both planes at the pixels near a border, four at a time.
  void compare(const Pair& pair, Worker& worker, int& witnesses, int& farther) const {
    const CreaseLanes planes(planes_[pair.first], planes_[pair.second], center_);
    const LaneMask first = fillMask(pair.first);
    const bool one_origin = grid_.origin_x.empty();
    const CreaseLanes::Heights of_all = planes.heightsAt(fill(0.0F), fill(0.0F), fill(0.0F));
    worker.open.clear();
    LaneMask apart = {}, of_farther = {};
    const auto compare_four = [&](int pixel, int which) {
      BeamLanes beams(grid_, pixel, kLanes);
      beams.valid &= (fillMask(which) & LaneMask{1, 2, 4, 8}) != LaneMask{};
      const LaneMask of_first = labelsAt(labels_, pixel, grid_.size() - pixel) == first;
      const auto heights = one_origin ? of_all : planes.heightsAt(beams.origin_x, beams.origin_y, beams.origin_z);
      const auto found = planes.compare(beams, heights, variance_.at(beams.range, pixel), of_first, kClearlyApart,
                                        kWithinNoise, kFarthestPoint);
      apart += found.apart;
      of_farther += found.apart & ~(of_first ^ found.first_farther);
      if (!anyLane(found.open)) return;
      for (int k = 0; k < kLanes; ++k) {
        if (found.open[k] != 0) worker.open.push_back({pixel + k, found.first_farther[k] != 0});
      }
    };
    worker.near.takeFours(compare_four);
    witnesses = countLanes(apart);
    farther = countLanes(of_farther);
  }

  const BeamGrid& grid_;
  const std::vector<Eigen::Vector3d>& planes_;
  const Eigen::Vector3d& center_;
  const DistanceVariance& variance_;
  const CreaseMeetings& meetings_;
  const LabelImage& labels_;
};

}  // namespace

void alignCreases(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, const CreaseMeetings& meetings,
                  CreaseMemory& memory, LabelImage& labels, int threads) {
  const std::vector<CreaseMeetings::Pair>& pairs = meetings.pairs;
  if (pairs.empty()) return;
  if (memory.changes.size() < pairs.size()) memory.changes.resize(pairs.size());
  memory.variance.set(image.noise, image.tolerance);
  const CreaseAligner aligner(image, planes, memory.variance, meetings, labels);
  forEachPart(threads, static_cast<int>(pairs.size()), memory.workers, [&](int k, Worker& kept) {
    Worker worker;  // on the thread's own stack: counts of two threads in one line of the cache would slow both
    std::swap(worker, kept);
    aligner.align(pairs[k], worker, memory.changes[k]);
    std::swap(worker, kept);
  });
  // Not before all pairs are known, and in their order: a pixel may be near several borders.
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (const Change& change : memory.changes[k]) labels.labels[change.pixel] = change.label;
  }
}

}  // namespace ppc
