// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_alignment.h"

#include "patch_plane_clustering/core/label_runs.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace ppc {
namespace {

using Meeting = CreaseMemory::Meeting;
using Candidate = CreaseMemory::Candidate;

constexpr int kReach = 6;                // pixels from a border that are looked at
constexpr double kClearlyApart = 1.0;    // distance of two planes that tells on which side one is seen, in sigmas
constexpr double kWithinNoise = 1.5;     // distance of two planes at which a point may be of either, in sigmas
constexpr double kFarthestPoint = 2.5;   // of a point from the plane that it is given to, in sigmas
constexpr int kFewestWitnesses = 5;      // points at which planes are clearly apart
constexpr double kLeastAgreement = 0.8;  // of the witnesses

class CreaseAligner {
 public:
  CreaseAligner(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
                const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, CreaseMemory& memory,
                LabelImage& labels)
      : grid_(grid),
        planes_(planes),
        center_(center),
        noise_(noise),
        tolerance_(tolerance),
        smallest_(smallest),
        memory_(memory),
        image_(labels),
        labels_(labels.labels.data()) {
    memory_.points.assign(planes.size(), 0);
    forEachRun(labels, [&](std::int32_t label, int begin, int end) { memory_.points[label] += end - begin; });
    memory_.seen.assign(static_cast<std::size_t>(grid.size()), -1);
    memory_.meetings.clear();
    memory_.changes.clear();
  }

  void align() {
    forEachChange(image_, [&](int pixel, int step, int) { meet(pixel, step); });
    std::vector<Meeting>& meetings = memory_.meetings;
    const auto key = [](const Meeting& m) { return std::tie(m.first, m.second, m.step, m.pixel); };
    std::sort(meetings.begin(), meetings.end(), [&](const Meeting& a, const Meeting& b) { return key(a) < key(b); });
    for (std::size_t begin = 0, end = 0; begin < meetings.size(); begin = end) {
      const std::int32_t first = meetings[begin].first, second = meetings[begin].second;
      memory_.near.clear();
      for (end = begin; end < meetings.size() && meetings[end].first == first && meetings[end].second == second; ++end) {
        lookAround(meetings[end], static_cast<int>(begin));
      }
      alignPair(first, second);
    }
    for (const CreaseMemory::Change& change : memory_.changes) labels_[change.pixel] = change.label;
  }

 private:
  void meet(int pixel, int step) {
    const std::int32_t a = labels_[pixel - step], b = labels_[pixel];
    if (a <= 0 || b <= 0 || memory_.points[a] < smallest_ || memory_.points[b] < smallest_) return;
    memory_.meetings.push_back({std::min(a, b), std::max(a, b), pixel, step});
  }

  // Looks at the pixels on both sides of a meeting, as far as they are of either label.
  void lookAround(const Meeting& meeting, int pair) {
    const int place = meeting.step == 1 ? meeting.pixel % grid_.cols : meeting.pixel / grid_.cols;
    const int count = meeting.step == 1 ? grid_.cols : grid_.rows;
    const auto walk = [&](int pixel, int step, int most) {
      for (int k = 0; k < most; ++k, pixel += step) {
        if (labels_[pixel] != meeting.first && labels_[pixel] != meeting.second) return;
        if (memory_.seen[pixel] == pair || !grid_.valid(pixel)) continue;
        memory_.seen[pixel] = pair;
        lookAt(pixel, meeting.first, meeting.second);
      }
    };
    walk(meeting.pixel - meeting.step, -meeting.step, std::min(kReach, place));
    walk(meeting.pixel, meeting.step, std::min(kReach, count - place));
  }

  // Range at which a beam meets a plane [m]; not finite or negative if it does not.
  double rangeOf(std::int32_t label, const Eigen::Vector3d& direction, const Eigen::Vector3d& origin) const {
    const Eigen::Vector3d& a = planes_[label];
    return (1.0 - a.dot(origin - center_)) / a.dot(direction);
  }

  void lookAt(int pixel, std::int32_t first, std::int32_t second) {
    const Eigen::Vector3d direction = grid_.direction(pixel).cast<double>(), origin = grid_.origin(pixel).cast<double>();
    const double of_first = rangeOf(first, direction, origin), of_second = rangeOf(second, direction, origin);
    if (!(of_first > 0.0) || !(of_second > 0.0)) return;
    const double noise = noise_.sigma(grid_.range[pixel]), floor = tolerance_.forNoise(noise).sigma_distance;
    const double sigma = std::sqrt(noise * noise + floor * floor), difference = of_first - of_second;
    const double residual = grid_.range[pixel] - (labels_[pixel] == first ? of_second : of_first);
    const bool witness = std::abs(difference) > kClearlyApart * sigma;
    const bool open = std::abs(difference) < kWithinNoise * sigma && std::abs(residual) < kFarthestPoint * sigma;
    memory_.near.push_back({pixel, difference > 0.0, witness, open});
  }

  void alignPair(std::int32_t first, std::int32_t second) {
    int witnesses = 0, farther = 0;  // those of them that are of the farther plane, as at the edge of a box
    for (const Candidate& candidate : memory_.near) {
      if (!candidate.witness) continue;
      ++witnesses;
      if ((labels_[candidate.pixel] == first) == candidate.first_farther) ++farther;
    }
    if (std::max(farther, witnesses - farther) < std::max<double>(kFewestWitnesses, kLeastAgreement * witnesses)) return;
    const bool farther_is_seen = 2 * farther > witnesses;
    for (const Candidate& candidate : memory_.near) {
      const std::int32_t label = candidate.first_farther == farther_is_seen ? first : second;
      if (candidate.open && label != labels_[candidate.pixel]) memory_.changes.push_back({candidate.pixel, label});
    }
  }

  const BeamGrid& grid_;
  const std::vector<Eigen::Vector3d>& planes_;
  const Eigen::Vector3d& center_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  CreaseMemory& memory_;
  const LabelImage& image_;
  std::int32_t* labels_;
};

}  // namespace

void alignCreases(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
                  const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, CreaseMemory& memory,
                  LabelImage& labels) {
  CreaseAligner(grid, planes, center, noise, tolerance, smallest, memory, labels).align();
}

}  // namespace ppc
