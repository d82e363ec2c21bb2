// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_trimming.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kMostPoints = 4000;
constexpr int kRounds = 12, kToleratedRounds = 3;
constexpr int kFits = 3;              // the first one of all points, then of those that are near
constexpr double kFarthest2 = 16.0;   // squared error at which a point is an outlier, in variances
constexpr double kFarthest = 6.0;     // error of a point that counts for its neighbours, in standard deviations
constexpr double kAgreement = 2.0;    // standard deviations of what errors of neighbours have in common
constexpr double kSignificant = 4.0;  // standard deviations of chi-square
constexpr double kFringeLimit = 3.0;  // of errors of the fringe, in standard deviations
constexpr double kLeastLeft = 0.75;   // of a region's points, that is still the same region
constexpr int kFewestPoints = 4;

using Candidate = TrimmingMemory::Candidate;
using Point = TrimmingMemory::Point;
using Work = TrimmingMemory::Work;
using Stretches = std::vector<PixelStretch>;

class Trimmer {
 public:
  Trimmer(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
          const CoplanarityTolerance& tolerance, int smallest, TrimmingMemory& memory, LabelImage& labels)
      : grid_(grid),
        center_(center),
        noise_(noise),
        tolerance_(tolerance),
        smallest_(smallest),
        memory_(memory),
        labels_(labels) {}

  void trimAll(int threads) {
    listCandidates(threads);
    const auto count = static_cast<int>(memory_.candidates.size());
    memory_.left.resize(std::max(memory_.left.size(), memory_.candidates.size()));  // what each has is kept
    memory_.trimmed.assign(memory_.candidates.size(), 0);
    forEachPart(threads, count, memory_.works, [&](int k, Work& work) {
      memory_.trimmed[k] = trim(memory_.candidates[k], work) ? 1 : 0;
      if (memory_.trimmed[k] != 0) memory_.left[k] = work.kept;
    });
    for (int k = 0; k < count; ++k) {
      if (memory_.trimmed[k] == 0) continue;
      const Candidate& region = memory_.candidates[k];
      for (std::size_t s = region.begin; s < region.end; ++s) paint(memory_.stretches[s], 0);
      for (const PixelStretch& stretch : memory_.left[k]) paint(stretch, region.label);
    }
  }

 private:
  void paint(const PixelStretch& stretch, std::int32_t label) {
    std::fill(labels_.labels.begin() + stretch.begin, labels_.labels.begin() + stretch.end, label);
  }

  void listCandidates(int threads) {
    std::vector<LabelRun>& runs = memory_.runs;
    listRuns(labels_, memory_.listing, runs, threads);
    memory_.points.assign(static_cast<std::size_t>(highestLabel(runs)) + 1, 0);
    for (const LabelRun& run : runs) memory_.points[run.label] += run.end - run.begin;
    const auto is_judged = [&](const LabelRun& run) {
      return memory_.points[run.label] >= smallest_ && memory_.points[run.label] <= kMostPoints;
    };
    runs.erase(std::remove_if(runs.begin(), runs.end(), [&](const LabelRun& run) { return !is_judged(run); }), runs.end());
    sortByLabel(runs);
    memory_.stretches.clear();
    for (const LabelRun& run : runs) memory_.stretches.push_back({run.begin, run.end});
    memory_.candidates.clear();
    forEachLabel(runs, [&](std::int32_t label, std::size_t begin, std::size_t end) {
      memory_.candidates.push_back({label, begin, end});
    });
  }

  // @return whether less is left of it than all: work.kept.
  bool trim(const Candidate& region, Work& work) const {
    Stretches& kept = work.kept;
    kept.assign(memory_.stretches.begin() + static_cast<std::ptrdiff_t>(region.begin),
                memory_.stretches.begin() + static_cast<std::ptrdiff_t>(region.end));
    Fit fit = fitTo(work);
    const auto all = static_cast<double>(work.points.size());
    if (fit.is_plane || all < smallest_) return false;
    const bool tolerated = isTolerated(work.points, fit);
    for (int round = tolerated ? kToleratedRounds : kRounds; round > 0; --round) {
      const Stretches& off = offFringe(grid_, kept.data(), kept.data() + kept.size(), planeOf(fit.a), fit.sigma,
                                       {kFringeLimit * fit.sigma, 0.0}, work.fringe);
      if (off.empty()) break;
      remove(off, work);
      fit = fitTo(work);
      if (static_cast<double>(work.points.size()) < kLeastLeft * all) break;
      if (fit.is_plane) return true;
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

  struct Fit {
    Eigen::Vector3d a = Eigen::Vector3d::Zero();
    double radius = 0.0, sigma = 0.0;  // of the points; root of the mean variance of one [m]
    double noise = 0.0;                // root of the mean variance of one, of noise alone [m]
    bool is_plane = true;              // as few points as none tell
  };

  // The plane of those of the kept points that are near it.
  Fit fitTo(Work& work) const {
    std::vector<Point>& points = work.points;
    points.clear();
    double variances = 0.0, noises = 0.0;
    for (const PixelStretch& stretch : work.kept) {
      for (int i = stretch.begin; i < stretch.end; ++i) {
        if (!grid_.valid(i)) continue;
        const Eigen::Vector3d at = grid_.point(i).cast<double>() - center_;
        const double sigma = noise_.sigma(grid_.range[i]), floor = tolerance_.forNoise(sigma).sigma_distance;
        const double variance = sigma * sigma + floor * floor;
        points.push_back({at, at.squaredNorm() / variance, i});
        variances += variance;
        noises += sigma * sigma;
      }
    }
    Fit fit;
    const double count = std::max<double>(1.0, static_cast<double>(points.size()));
    fit.sigma = std::sqrt(variances / count);
    fit.noise = std::sqrt(noises / count);
    for (int k = 0; k < kFits; ++k) {
      Moments sum;
      for (const Point& point : points) {
        if (k > 0 && !(squaredError(point, fit.a) < kFarthest2)) continue;
        sum.add(point.at.x(), point.at.y(), point.at.z(), point.weight);
      }
      if (sum.n < kFewestPoints) {
        fit.is_plane = k == 0;  // else none of many is near the plane of all
        return fit;
      }
      const PlaneFit plane = fitPlane(sum);
      fit.a = plane.a;
      if (k == 0 && plane.chi2 <= mostOf(sum.n)) return fit;  // so it is with errors capped
      fit.radius = sum.radius();
    }
    fit.is_plane = isPlane(points, fit.a, [](const Point&) { return 1.0; }) || !isSmooth(points, fit.a);
    return fit;
  }

  // Of a range, in variances.
  static double squaredError(const Point& point, const Eigen::Vector3d& a) {
    const double along = a.dot(point.at), missed = 1.0 - along;
    return along > 0.0 ? point.weight * missed * missed / (along * along) : kFarthest2;
  }

  // Whether errors of neighbours in a row or column agree, as those of another plane's points do; those of noise larger than
  // it is known to be, on dark surfaces or far away, do not.
  bool isSmooth(const std::vector<Point>& points, const Eigen::Vector3d& a) const {
    double products = 0.0, squares = 0.0;
    int pairs = 0;
    std::size_t above = 0;
    const auto errorOf = [&](const Point& point) {
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

  // Whether chi-square is what noise makes it. @param scaleOf what a point's variance is over what its weight tells.
  template <typename F>
  static bool isPlane(const std::vector<Point>& points, const Eigen::Vector3d& a, const F& scaleOf) {
    double chi2 = 0.0;
    for (const Point& point : points) chi2 += std::min(kFarthest2, squaredError(point, a) / scaleOf(point));
    return chi2 <= mostOf(static_cast<double>(points.size()));
  }
  static double mostOf(double n) { return n + kSignificant * std::sqrt(2.0 * n); }

  // Whether it is with all that planes are allowed, turned by the angle and seen at a slant.
  bool isTolerated(const std::vector<Point>& points, const Fit& fit) const {
    const CoplanarityTolerance tolerance = tolerance_.forNoise(fit.noise);
    const double known2 = tolerance.sigma_distance * tolerance.sigma_distance;  // of which the weights know
    const double turned = tolerance.sigma_angle * fit.radius;
    return isPlane(points, fit.a, [&](const Point& point) {
      const double range2 = point.at.squaredNorm();
      const double tau2 = (known2 + turned * turned) * secantSquared(fit.a, std::sqrt(range2));
      return 1.0 + (tau2 - known2) * point.weight / range2;
    });
  }

  Plane planeOf(const Eigen::Vector3d& a) const {
    const Eigen::Vector3d normal = -a.normalized();
    return {normal, normal.dot(center_) - 1.0 / a.norm()};
  }

  const BeamGrid& grid_;
  const Eigen::Vector3d& center_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  TrimmingMemory& memory_;
  LabelImage& labels_;
};

}  // namespace

void trimRegions(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance, int smallest, TrimmingMemory& memory, LabelImage& labels,
                 int threads) {
  if (tolerance.isWhite()) Trimmer(grid, center, noise, tolerance, smallest, memory, labels).trimAll(threads);
}

}  // namespace ppc
