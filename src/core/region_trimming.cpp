// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_trimming.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kRounds = 12, kToleratedRounds = 3;
constexpr double kFarthest = 6.0;     // error of a point that counts for its neighbours, in standard deviations
constexpr double kAgreement = 2.0;    // standard deviations of what errors of neighbours have in common
constexpr double kFringeLimit = 3.0;  // of errors of the fringe, in standard deviations
constexpr double kLeastLeft = 0.75;   // of a region's points, that is still the same region

using Region = SmallRegions::Region;
using Work = TrimmingMemory::Work;
using Stretches = std::vector<PixelStretch>;

class Trimmer {
 public:
  Trimmer(const JudgedImage& image, TrimmingMemory& memory, LabelImage& labels)
      : image_(image), grid_(image.grid), memory_(memory), labels_(labels) {}

  void trimAll(int threads) {
    listRuns(labels_, memory_.listing, memory_.runs, threads);
    SmallRegions& small = memory_.small;
    small.list(memory_.runs, image_.smallest);
    const std::size_t count = small.regions.size();
    memory_.left.resize(std::max(memory_.left.size(), count));  // what each has is kept
    memory_.trimmed.assign(count, 0);
    forEachPart(threads, static_cast<int>(count), memory_.works, [&](int k, Work& work) {
      memory_.trimmed[k] = trim(small.regions[k], work) ? 1 : 0;
      if (memory_.trimmed[k] != 0) memory_.left[k] = work.kept;
    });
    for (std::size_t k = 0; k < count; ++k) {
      if (memory_.trimmed[k] == 0) continue;
      const Region& region = small.regions[k];
      for (std::size_t s = region.begin; s < region.end; ++s) paint(small.stretches[s], 0);
      for (const PixelStretch& stretch : memory_.left[k]) paint(stretch, region.label);
    }
  }

 private:
  void paint(const PixelStretch& stretch, std::int32_t label) {
    std::fill(labels_.labels.begin() + stretch.begin, labels_.labels.begin() + stretch.end, label);
  }

  // @return whether less is left of it than all: work.kept.
  bool trim(const Region& region, Work& work) const {
    Stretches& kept = work.kept;
    const auto stretches = memory_.small.stretches.begin();
    kept.assign(stretches + static_cast<std::ptrdiff_t>(region.begin), stretches + static_cast<std::ptrdiff_t>(region.end));
    NearFit fit = fitTo(work);
    const auto all = static_cast<double>(work.points.size());
    if (isPlane(work.points, fit) || all < image_.smallest) return false;
    const bool tolerated = isTolerated(work.points, fit);
    for (int round = tolerated ? kToleratedRounds : kRounds; round > 0; --round) {
      Fringe fringe(grid_, kept.data(), kept.data() + kept.size(), work.fringe);
      const Stretches& off = fringe.off({{planeOf(fit.a), fit.sigma}}, {kFringeLimit * fit.sigma, 0.0});
      if (off.empty()) break;
      remove(off, work);
      fit = fitTo(work);
      if (static_cast<double>(work.points.size()) < kLeastLeft * all) break;
      if (isPlane(work.points, fit)) return true;
    }
    kept.clear();
    return !tolerated;
  }

  // Takes stretches of them off those that are kept, all in scan order.
  static void remove(const Stretches& off, Work& work) {
    work.next.clear();
    auto hole = off.begin();
    for (const PixelStretch& stretch : work.kept) {
      int begin = stretch.begin;
      for (; hole != off.end() && hole->begin < stretch.end; ++hole) {
        if (hole->begin > begin) work.next.push_back({begin, hole->begin});
        begin = hole->end;
      }
      if (begin < stretch.end) work.next.push_back({begin, stretch.end});
    }
    std::swap(work.kept, work.next);
  }

  NearFit fitTo(Work& work) const {
    const Stretches& kept = work.kept;
    return fitNear(image_, kept.data(), kept.data() + kept.size(), work.points);
  }

  // Of few points nothing tells.
  bool isPlane(const std::vector<RegionPoint>& points, const NearFit& fit) const {
    if (fit.of != NearFit::Of::kNear) return fit.of != NearFit::Of::kNone;
    return isExplained(points, fit.a, [](const RegionPoint&) { return 1.0; }) || !isSmooth(points, fit.a);
  }

  // Whether errors of neighbours in a row or column agree, as those of another plane's points do; those of noise larger than
  // it is known to be, on dark surfaces or far away, do not.
  bool isSmooth(const std::vector<RegionPoint>& points, const Eigen::Vector3d& a) const {
    double products = 0.0, squares = 0.0;
    int pairs = 0;
    std::size_t above = 0;
    const auto errorOf = [&](const RegionPoint& point) {
      const double along = a.dot(point.at);
      const double error = along > 0.0 ? std::sqrt(point.weight) * (1.0 - along) / along : 0.0;
      return std::abs(error) < kFarthest ? error : 0.0;
    };
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double error = errorOf(points[k]);
      squares += error * error;
      if (k > 0 && points[k - 1].pixel + 1 == points[k].pixel && points[k].pixel % grid_.cols != 0) {
        products += error * errorOf(points[k - 1]);
        ++pairs;
      }
      while (points[above].pixel + grid_.cols < points[k].pixel) ++above;
      if (points[above].pixel + grid_.cols == points[k].pixel) {
        products += error * errorOf(points[above]);
        ++pairs;
      }
    }
    return products * static_cast<double>(points.size()) > kAgreement * squares * std::sqrt(static_cast<double>(pairs));
  }

  // Whether chi-square is what noise makes it with all that planes are allowed, turned by the angle and seen at a slant.
  bool isTolerated(const std::vector<RegionPoint>& points, const NearFit& fit) const {
    return isExplained(points, fit.a, ToleratedScale(fit, image_.tolerance));
  }

  Plane planeOf(const Eigen::Vector3d& a) const {
    const Eigen::Vector3d normal = -a.normalized();
    return {normal, normal.dot(image_.center) - 1.0 / a.norm()};
  }

  const JudgedImage& image_;
  const BeamGrid& grid_;
  TrimmingMemory& memory_;
  LabelImage& labels_;
};

}  // namespace

void trimRegions(const JudgedImage& image, TrimmingMemory& memory, LabelImage& labels, int threads) {
  if (image.tolerance.isWhite()) Trimmer(image, memory, labels).trimAll(threads);
}

}  // namespace ppc
