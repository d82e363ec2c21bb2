// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/surface_fan.h"

#include "patch_plane_clustering/core/quadratic_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr double kFanAngle = 0.54;     // smallest angle between two strips of a fan, in max_turn
constexpr double kNarrowAngle = 0.22;  // likewise, if they bend as they are turned against each other
constexpr double kNarrowRadius = 4.0;  // largest radius of such strips: wider bows are those of ceilings and walls [m]
constexpr double kNarrowTurn = 0.6;    // turn of each over the angle between them that makes it so
constexpr int kFanSizes = 6;           // largest ratio of their sizes
constexpr double kFanRatio = 0.15;     // misfit of one quadratic surface over that of one plane, for two strips of a fan
constexpr double kFanMisfit = 0.1;     // the same misfit per point, in units of the noise variance
// Misfit of one quadratic surface over that of two planes, for no fan: in general, and for a fine sensor.
constexpr double kCreaseRatio = 4.0, kFineCreaseRatio = 1.5;
constexpr double kWideFan = 0.93;   // angle between two strips from which on the sides of an edge must be ruled out [rad]
constexpr double kWidestFan = 2.0;  // largest angle between two strips of a fan [rad]
constexpr double kWideFanRatio = 0.035;  // as kFanRatio, beyond kWideFan: an evenly sampled edge of two planes has 1/16
constexpr double kLimbAngle = 0.31;      // smallest angle of a strip at the limb of a curved surface to its neighbour [rad]
constexpr double kLimbRatio = 0.65;      // as kFanRatio, for such a strip
constexpr double kLimbMisfit = 0.6;      // as kFanMisfit, likewise
constexpr int kFew = 8;                  // one in so many samples tells that two regions are far from any one surface
constexpr double kFarMisfit = 2.0;       // ... by so many times the misfit that is asked about

// Radius of an evenly sampled strip of a cylinder [m]: its parabola of height h = w^2 / 8 R over the width w = turn R has
// the root mean square 2 h / (3 sqrt 5).
double radiusOf(const Bend& bend) { return 12.0 * std::sqrt(5.0) * bend.amplitude / (bend.turn * bend.turn); }

// How much worse one surface serves two regions than two of their own do, in chi-square.
struct Misfit {
  double plane = 0.0;      // of one plane
  double quadratic = 0.0;  // of one quadratic surface
  double own = 0.0;        // of their own planes
  double allowed = 0.0;    // what noise and tolerance are worth in all of the points

  bool isSmooth(double ratio, double misfit) const { return quadratic < ratio * plane && quadratic < misfit * allowed; }
};

class CommonSurface {
 public:
  CommonSurface(const BentRegion& a, const BentRegion& b, const CoplanarityTolerance& tolerance)
      : a_(a),
        b_(b),
        tolerance_(tolerance),
        n_((a.region.points * a.region.plane.normal + b.region.points * b.region.plane.normal).normalized()),
        s_(n_.unitOrthogonal()),
        t_(n_.cross(s_)),
        origin_((a.region.points * a.region.samples.center + b.region.points * b.region.samples.center) /
                (a.region.points + b.region.points)) {}

  // Whether few samples are enough to rule out that one quadratic surface serves both by `misfit`. A surface leaves at least
  // as much of all samples as the best one leaves of some; and the regions' own surfaces leave at most what their planes do.
  bool isRuledOut(double misfit) const {
    QuadraticSums sums = sumQuadraticAbout(origin_, a_.region.samples, s_, t_, kFew);
    const QuadraticFit both = fitQuadratic(sums += sumQuadraticAbout(origin_, b_.region.samples, s_, t_, kFew));
    const double least = both.quadratic_chi2 - ownPlaneChi2(a_) - ownPlaneChi2(b_);
    return least > kFarMisfit * misfit * allowed(a_.bend.weight + b_.bend.weight);
  }

  Misfit fit() const {
    QuadraticSums sums = sumQuadraticAbout(origin_, a_.region.samples, s_, t_);
    const QuadraticSums sums_b = sumQuadraticAbout(origin_, b_.region.samples, s_, t_);
    const QuadraticFit fit_a = fitQuadratic(sums), fit_b = fitQuadratic(sums_b);
    const QuadraticFit both = fitQuadratic(sums += sums_b);
    return {both.plane_chi2 - fit_a.plane_chi2 - fit_b.plane_chi2,
            both.quadratic_chi2 - fit_a.quadratic_chi2 - fit_b.quadratic_chi2,
            fit_a.plane_chi2 + fit_b.plane_chi2 - fit_a.quadratic_chi2 - fit_b.quadratic_chi2, allowed(both.weight)};
  }

  // Whether two planes serve so much better than this surface, however little that leaves of tolerances: narrow faces at a
  // crease.
  bool isCreased(const Misfit& misfit) const {
    const double ratio = tolerance_.isFine(sigma()) ? kFineCreaseRatio : kCreaseRatio;
    return misfit.quadratic > ratio * (misfit.own + kBendSignificance * tolerance_.inflation);
  }

 private:
  double allowed(double weight) const {
    const double points = a_.region.stride * a_.region.samples.used + b_.region.stride * b_.region.samples.used;
    const double distance = tolerance_.forNoise(sigma()).sigma_distance;
    return tolerance_.inflation * points + distance * distance * weight;
  }

  double sigma() const { return std::max(a_.region.sigma, b_.region.sigma); }

  // Heights along n, not along the region's own normal, are larger.
  double ownPlaneChi2(const BentRegion& region) const {
    const double cosine = n_.dot(region.region.samples.normal);
    return region.bend.chi2 / (cosine * cosine);
  }

  const BentRegion &a_, &b_;
  const CoplanarityTolerance& tolerance_;
  Eigen::Vector3d n_, s_, t_, origin_;
};

double angleBetween(const RegionSamples& a, const RegionSamples& b) {
  return std::acos(std::clamp(a.plane.normal.dot(b.plane.normal), -1.0, 1.0));
}

}  // namespace

bool isFan(const BentRegion& a, const BentRegion& b, const CoplanarityTolerance& tolerance, double max_turn) {
  // A scrap beside a large plane proves nothing about the plane.
  const int points_a = a.region.points, points_b = b.region.points;
  if (points_a > kFanSizes * points_b || points_b > kFanSizes * points_a) return false;
  const double angle = angleBetween(a.region, b.region);
  if (angle < kNarrowAngle * max_turn || angle > kWidestFan) return false;
  const auto bends = [&](const Bend& bend) {
    return bend.turn > kNarrowTurn * angle && radiusOf(bend) < kNarrowRadius &&
           bend.excess > kBendSignificance * tolerance.inflation;
  };
  if (angle < kFanAngle * max_turn && !(bends(a.bend) && bends(b.bend))) return false;
  const CommonSurface common(a, b, tolerance);
  if (common.isRuledOut(kFanMisfit)) return false;
  const Misfit misfit = common.fit();
  return misfit.plane > kBendSignificance * tolerance.inflation && !common.isCreased(misfit) &&
         misfit.isSmooth(angle < kWideFan ? kFanRatio : kWideFanRatio, kFanMisfit);
}

bool isMoreOfFan(const BentRegion& strip, const BentRegion& beside, const CoplanarityTolerance& tolerance, double max_turn) {
  const double angle = angleBetween(strip.region, beside.region);
  if (angle < kNarrowAngle * max_turn || angle > kWidestFan) return false;
  const CommonSurface common(strip, beside, tolerance);
  if (common.isRuledOut(std::max(kFanMisfit, kLimbMisfit))) return false;
  const Misfit misfit = common.fit();
  if (misfit.plane < kBendSignificance * tolerance.inflation) return false;
  if (angle < kWideFan && misfit.isSmooth(kFanRatio, kFanMisfit)) return !common.isCreased(misfit);
  return angle > kLimbAngle && strip.region.points < beside.region.points && misfit.isSmooth(kLimbRatio, kLimbMisfit);
}

}  // namespace ppc
