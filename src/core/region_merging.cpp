// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_merging.h"

#include "patch_plane_clustering/core/label_meetings.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/whole_tolerance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

constexpr double kStepTolerance = 1.0;  // tolerance of a step along a border over that from patch to patch
// Regions turned by less, in tolerances of the angle, may be one bowed wall. For them:
constexpr double kHardlyTurned = 10.0;
constexpr double kWholeTurn = 4.0;     // tolerance of the angle over a whole region over that from patch to patch
constexpr double kMaxBowRadius = 1.0;  // the radius for it [m]
constexpr double kBowTurn = 0.14;      // largest angle between two parts of one bowed surface [rad]
constexpr double kWideRadius = 8.0;    // least radius of a wide bow [m]
constexpr double kBowEvidence = 1.5;   // least misfit of the planes of both parts at the border over that of one plane there
constexpr double kWideEvidence = 1.1;  // likewise, for parts of a wide bow
constexpr double kBowSignificance = 25.0;  // far beyond chi-square with 3 degrees of freedom
constexpr double kCreaseTolerance = 0.8;   // of a part turned by more than kBowTurn, over that from patch to patch
constexpr double kCreaseSignificance = 50.0;
constexpr int kBorderSteps = 2;  // depth of a border in cells
constexpr int kMinBorderPoints = 6;
constexpr int kFewPairs = 24;  // not worth a second thread

using Whole = MergeMemory::Whole;

// One plane for both as wholes. Walls bow: regions that are hardly turned against each other may differ by more.
double wholeSimilarity(const Whole& a, const Whole& b, const PlaneFit& joint, const NoiseModel& noise,
                       const CoplanarityTolerance& tolerance) {
  const Moments& small = a.moments.n < b.moments.n ? a.moments : b.moments;
  const double range = small.mean().norm();
  const double sigma = noise.sigmaOf(small, range);
  CoplanarityTolerance whole = wholeTolerance(tolerance, sigma, small.n);
  double max_radius = kMaxWholeRadius;
  if (a.fit.normal().dot(b.fit.normal()) > std::cos(kHardlyTurned * tolerance.sigma_angle)) {
    whole.sigma_angle *= kWholeTurn;
    max_radius = kMaxBowRadius;
  }
  // Where errors are correlated, the planes of the parts are not known well enough.
  const double sec2 = tolerance.isWhite() ? leastSecantSquared(joint, a.fit, b.fit, range) : secantSquared(joint.a, range);
  return similarity(joint.chi2 - a.fit.chi2 - b.fit.chi2, small.n / (sigma * sigma), std::min(small.radius(), max_radius),
                    sec2, whole);
}

double stepSimilarity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d mean_a = a.mean(), mean_b = b.mean();
  const double gap = joint.normal().dot(mean_a - mean_b);
  const double range = 0.5 * (mean_a.norm() + mean_b.norm());
  const double sigma_a = noise.sigmaOf(a, range), sigma_b = noise.sigmaOf(b, range);
  const double variance =
      (sigma_a * sigma_a * tolerance.inflationOf(a.n) / a.n + sigma_b * sigma_b * tolerance.inflationOf(b.n) / b.n) /
      secantSquared(joint.a, range);
  const double step = kStepTolerance * tolerance.forNoise(std::max(sigma_a, sigma_b)).sigma_distance;
  return std::exp(-0.5 * gap * gap / (variance + step * step));
}

// One bowed surface (a sagging floor, a wall that is not flat): turned a little, and smooth where the two meet. At a crease
// the planes of the wholes fit their sides of the border best; across a bow, one plane of its own fits the border better.
bool isBowed(const Whole& a, const Whole& b, bool wide, const Moments& side_a, const Moments& side_b,
             const CoplanarityTolerance& tolerance) {
  const double crease = chiSquare(side_a, a.fit.a) + chiSquare(side_b, b.fit.a);
  return crease > (wide ? kWideEvidence : kBowEvidence) * fitPlane(side_a + side_b).chi2 +
                      kBowSignificance * tolerance.inflationOf(std::min(side_a.n, side_b.n));
}

// Whether two parts that are turned by more than those of a bow are so for certain, however small the distances are that it
// makes: the smaller one's own plane serves it far better than the best one that is parallel to the other's. Only where the
// tolerance shrinks with the noise: seen by a coarser sensor, strips of what bends must become one for their bend to show.
bool isCrease(const Whole& a, const Whole& b, const NoiseModel& noise, const CoplanarityTolerance& tolerance) {
  const bool first = a.moments.n < b.moments.n;
  const Whole &small = first ? a : b, &large = first ? b : a;
  const Moments& m = small.moments;
  const double range = m.mean().norm(), sigma = noise.sigmaOf(m, range);
  if (!tolerance.isFine(sigma)) return false;
  const double distance = kCreaseTolerance * tolerance.forNoise(sigma).sigma_distance;
  const Eigen::Vector3d normal = large.fit.normal();
  const double along = normal.dot(Eigen::Vector3d(m.x, m.y, m.z));
  const double square = chiSquare(m, normal) - m.w + 2.0 * along;  // of 1 / distance, in that of the parallel plane
  const double turned = m.w - along * along / square - small.fit.chi2;
  return turned > kCreaseSignificance * tolerance.inflationOf(m.n) +
                      m.n / (sigma * sigma) * distance * distance * secantSquared(small.fit.a, range);
}

// Whether two parts are turned as little, for the distance between them, as those of a ceiling or wall that sags.
bool isWideBow(const Whole& a, const Whole& b) {
  const double angle = std::acos(std::min(1.0, a.fit.normal().dot(b.fit.normal())));
  return (a.moments.mean() - b.moments.mean()).norm() > kWideRadius * angle;
}

// Height of a step, and the points that it is known from: its variance is that of a point over them, and up to four times
// that, as a cell may meet several others.
struct Step {
  double height = 0.0, points = 0.0;
};

// No step, and that for certain: what noise leaves open counts against it, by the larger of these variances.
bool isLevel(const Step& step, const Moments& a, const Moments& b, const NoiseModel& noise,
             const CoplanarityTolerance& tolerance, double threshold) {
  if (!(step.points > 0.0)) return false;
  const double range = (a + b).mean().norm(), sigma = std::max(noise.sigmaOf(a, range), noise.sigmaOf(b, range));
  const double variance = sigma * sigma * tolerance.inflation / step.points;
  const double allowed = kStepTolerance * tolerance.forNoise(sigma).sigma_distance;
  return step.height * step.height + 4.0 * variance <= greatestMisfit(threshold) * allowed * allowed;
}

// Sums both sides of a border: what the two labels have in cells within kBorderSteps of those where they meet.
class BorderSums {
 public:
  BorderSums(const PatchGrid& cells, const CellShares& all, const MergeMemory& memory, MergeMemory::Border& border)
      : cells_(cells),
        all_(all),
        meetings_(memory.meetings.all),
        names_(memory.names),
        reached_(border.reached),
        wave_(border.wave),
        border_(border.latest) {}

  // Of all meetings of two labels.
  std::pair<Moments, Moments> measure(const LabelPair& pair, const MeetingGroup* begin, const MeetingGroup* end) {
    ++border_;
    wave_.clear();
    const auto take = [&](int i) {
      if (reached_[i] == border_) return;
      reached_[i] = border_;
      wave_.push_back(i);
    };
    forEachMeeting(begin, end, [&](int cell, int other) {
      take(cell);
      take(other);
    });
    std::size_t next = 0;
    for (int step = 0; step < kBorderSteps; ++step) {
      const std::size_t last = wave_.size();
      for (; next < last; ++next) cells_.forEachNeighbour(wave_[next], take);
    }
    std::pair<Moments, Moments> sums;
    for (const int i : wave_) {
      for (int s = all_.begin[i]; s < all_.begin[i + 1]; ++s) {
        const std::int32_t label = names_[all_.labels[s]];
        if (label == pair.first) sums.first += all_.momentsOf(cells_, i, s);
        if (label == pair.second) sums.second += all_.momentsOf(cells_, i, s);
      }
    }
    return sums;
  }

  /// The step between two labels along a normal, from the nearest of both: where they meet.
  Step measureStep(const LabelPair& pair, const MeetingGroup* begin, const MeetingGroup* end,
                   const Eigen::Vector3d& normal) const {
    Step step;
    forEachMeeting(begin, end, [&](int cell, int other) {
      const Moments a = momentsIn(cell, pair.first), b = momentsIn(other, pair.second);
      if (a.n == 0 || b.n == 0) return;
      const double points = 1.0 / (1.0 / a.n + 1.0 / b.n);
      step.height += points * normal.dot(b.mean() - a.mean());
      step.points += points;
    });
    if (step.points > 0.0) step.height /= step.points;
    return step;
  }

 private:
  // Calls f(cell of the lower label, of the higher).
  template <typename F>
  void forEachMeeting(const MeetingGroup* begin, const MeetingGroup* end, F&& f) const {
    for (const MeetingGroup* group = begin; group != end; ++group) {
      for (int m = group->begin; m < group->end; ++m) {
        const Meeting& at = meetings_[m];
        f(group->swapped ? at.other : at.cell, group->swapped ? at.cell : at.other);
      }
    }
  }

  // What a label, by its name now, has in a cell.
  Moments momentsIn(int cell, std::int32_t label) const {
    Moments sum;
    for (int s = all_.begin[cell]; s < all_.begin[cell + 1]; ++s) {
      if (names_[all_.labels[s]] == label) sum += all_.momentsOf(cells_, cell, s);
    }
    return sum;
  }

  const PatchGrid& cells_;
  const CellShares& all_;
  const std::vector<Meeting>& meetings_;
  const std::vector<std::int32_t>& names_;
  std::vector<int>& reached_;  // the last border that took the cell
  std::vector<int>& wave_;
  int& border_;
};

// Names the labels of memory.names by what they are merged into.
void nameMerged(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                MergeMemory& memory, const CellShares& shares, std::vector<Eigen::Vector3d>& planes, int threads) {
  std::vector<Whole>& whole = memory.whole;
  whole.clear();
  whole.reserve(shares.sums.size());
  for (const Moments& sum : shares.sums) whole.push_back({sum, fitPlane(sum)});
  std::vector<std::int32_t>&names = memory.names, &now = memory.now;
  names.resize(whole.size());
  std::iota(names.begin(), names.end(), 0);
  std::vector<char>&fresh = memory.fresh, &changed = memory.changed;
  fresh.assign(whole.size(), 1);
  findMeetings(cells, shares, memory.meetings, threads);
  groupMeetings(memory.meetings);
  std::vector<MeetingGroup>& groups = memory.meetings.groups;
  std::vector<MergeMemory::Border>& borders = memory.borders;
  if (borders.size() < static_cast<std::size_t>(threads)) borders.resize(static_cast<std::size_t>(threads));
  for (MergeMemory::Border& border : borders) {
    border.reached.assign(cells.patches.size(), -1);
    border.latest = -1;
  }
  std::vector<std::pair<double, LabelPair>>& candidates = memory.candidates;
  while (true) {
    memory.pairs.clear();
    for (std::size_t begin = 0, end = 0; begin < groups.size(); begin = end) {
      const LabelPair pair = Meeting::pairOf(groups[begin].key);
      while (end < groups.size() && groups[end].key == groups[begin].key) ++end;
      if ((fresh[pair.first] | fresh[pair.second]) != 0) {
        memory.pairs.emplace_back(static_cast<int>(begin), static_cast<int>(end));
      }
    }
    for (MergeMemory::Border& border : borders) border.candidates.clear();
    const int count = static_cast<int>(memory.pairs.size());
    forEachRange(count < kFewPairs ? 1 : threads, count, borders,
                 [&](int first_pair, int last_pair, MergeMemory::Border& border) {
                   BorderSums sums(cells, shares, memory, border);
                   for (int k = first_pair; k < last_pair; ++k) {
                     const auto [begin, end] = memory.pairs[k];
                     const LabelPair pair = Meeting::pairOf(groups[begin].key);
                     const Whole& a = whole[pair.first];
                     const Whole& b = whole[pair.second];
                     const PlaneFit joint = fitPlane(a.moments + b.moments);
                     const double s = wholeSimilarity(a, b, joint, noise, tolerance);
                     const bool may_bow = a.fit.normal().dot(b.fit.normal()) > std::cos(kBowTurn);
                     if (!may_bow && (s < threshold || isCrease(a, b, noise, tolerance))) continue;
                     const auto [first, second] = sums.measure(pair, &groups[begin], groups.data() + end);
                     if (first.n < kMinBorderPoints || second.n < kMinBorderPoints) continue;
                     // Over a wide bow, the plane of both leaves the border: a step shows in the nearest of both sides
                     // alone.
                     const bool level = stepSimilarity(first, second, joint, noise, tolerance) >= threshold;
                     const bool wide = may_bow && isWideBow(a, b);
                     if (!level && !wide) continue;
                     if (!(level && s >= threshold) && !isBowed(a, b, wide, first, second, tolerance)) continue;
                     if (!level) {
                       const Eigen::Vector3d normal = (a.fit.normal() + b.fit.normal()).normalized();
                       const Step step = sums.measureStep(pair, &groups[begin], groups.data() + end, normal);
                       if (!isLevel(step, first, second, noise, tolerance, threshold)) continue;
                     }
                     border.candidates.emplace_back(-s, pair);
                   }
                 });
    candidates.clear();
    for (const MergeMemory::Border& border : borders) {
      candidates.insert(candidates.end(), border.candidates.begin(), border.candidates.end());
    }
    if (candidates.empty()) break;
    std::sort(candidates.begin(), candidates.end());
    changed.assign(whole.size(), 0);
    now.resize(whole.size());
    std::iota(now.begin(), now.end(), 0);
    for (const auto& [s, pair] : candidates) {
      if ((changed[pair.first] | changed[pair.second]) != 0) continue;
      changed[pair.first] = changed[pair.second] = 1;
      Whole& joined = whole[pair.first];
      joined.moments += whole[pair.second].moments;
      joined.fit = fitPlane(joined.moments);
      now[pair.second] = pair.first;
    }
    for (std::int32_t& label : names) label = now[label];
    renameGroups(now, groups);
    std::swap(fresh, changed);
  }
  planes.assign(whole.size(), Eigen::Vector3d::Zero());
  for (const std::int32_t name : names) planes[name] = whole[name].fit.a;
}

}  // namespace

void mergeShares(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                 MergeMemory& memory, CellShares& shares, std::vector<Eigen::Vector3d>& planes, int threads) {
  nameMerged(cells, noise, tolerance, threshold, memory, shares, planes, threads);
  renameShares(memory.names, shares);
}

void mergeLabels(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double threshold,
                 MergeMemory& memory, CellShares& shares, LabelImage& labels, std::vector<LabelRun>& runs,
                 std::vector<Eigen::Vector3d>& planes, int threads) {
  nameMerged(cells, noise, tolerance, threshold, memory, shares, planes, threads);
  Beside rename(threads, [&] { renameShares(memory.names, shares); });
  renameAndList(memory.names, labels, memory.listing, runs, threads);
  rename.wait();
}

}  // namespace ppc
