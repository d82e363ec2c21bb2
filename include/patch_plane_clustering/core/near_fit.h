// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/moments.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ppc {

/// @brief A measurement of a region.
struct RegionPoint {
  Eigen::Vector3d at;  ///< about the planes' origin [m]
  double weight;       ///< see Moments: of noise and CoplanarityTolerance::sigma_distance
  int pixel;           ///< where it is in the image

  /// One standard deviation of its range [m].
  double deviation() const { return at.norm() / std::sqrt(weight); }

  /// Error at which a point is an outlier, squared, in variances.
  static constexpr double kFarthest2 = 16.0;

  /// Of its range against that of plane `a` (see moments.h), squared, in variances; infinite if its beam misses the plane.
  double squaredError(const Eigen::Vector3d& a) const {
    const double along = a.dot(at), missed = 1.0 - along;
    return along > 0.0 ? weight * missed * missed / (along * along) : std::numeric_limits<double>::infinity();
  }
};

/// @brief Variance of a range, of noise `sigma` and CoplanarityTolerance::sigma_distance [m^2].
inline double varianceOf(const JudgedImage& image, double sigma) {
  const double floor = image.tolerance.forNoise(sigma).sigma_distance;
  return sigma * sigma + floor * floor;
}

/// @brief The measurement at a pixel that has one. @param variance of its range, see varianceOf() [m^2].
inline RegionPoint regionPointAt(const JudgedImage& image, int pixel, double variance) {
  const Eigen::Vector3d at = image.grid.point(pixel).cast<double>() - image.center;
  return {at, at.squaredNorm() / variance, pixel};
}

/// @brief The measurement at any pixel; of weight 0 if there is none.
inline RegionPoint regionPointAt(const JudgedImage& image, int pixel) {
  if (!image.grid.valid(pixel)) return {Eigen::Vector3d::Zero(), 0.0, pixel};
  return regionPointAt(image, pixel, varianceOf(image, image.noise.sigmaAt(pixel, image.grid.range[pixel])));
}

/// @brief Whether it is a measurement, and no outlier of plane `a` (see moments.h).
inline bool isNear(const RegionPoint& point, const Eigen::Vector3d& a) {
  return point.weight > 0.0 && point.squaredError(a) < RegionPoint::kFarthest2;
}

inline void addPoint(const RegionPoint& point, Moments& sum) {
  sum.add(point.at.x(), point.at.y(), point.at.z(), point.weight);
}

/// @brief Moments of labels: of those of their points that are near their planes. @param wanted whether those of each label
/// are. @param planes a (see moments.h) of every label. @param sums overwritten; index = label.
void sumNear(const JudgedImage& image, const std::vector<LabelRun>& runs, const std::vector<char>& wanted,
             const std::vector<Eigen::Vector3d>& planes, std::vector<Moments>& sums);

/// @brief The plane of those points of a region that are near it.
struct NearFit {
  enum class Of {
    kFew,   ///< there are fewer than four points: no plane
    kAll,   ///< it is that of all points, whose chi-square is what noise makes it
    kNear,  ///< it is that of the points that are not outliers
    kNone   ///< no plane: of many points, fewer than four are near one
  };
  Of of = Of::kFew;
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< see moments.h
  double radius = 0.0;                          ///< of the points fitted [m]
  int points = 0;                               ///< how many were fitted
  double sigma = 0.0;                           ///< root of the mean variance of a point [m]
  double noise = 0.0;                           ///< the same of noise alone [m]
};

/// @brief The largest chi-square that noise makes of n points on a plane: the mean and four standard deviations.
inline double mostChiSquare(double n) { return n + 4.0 * std::sqrt(2.0 * n); }

/// @brief Fits a plane to the measurements of stretches of pixels, along their beams. If not all are explained by noise,
/// outliers are left out, twice. Deterministic; thread-safe.
/// @param begin,end stretches of one region. @param points overwritten: all measurements.
NearFit fitNear(const JudgedImage& image, const PixelStretch* begin, const PixelStretch* end,
                std::vector<RegionPoint>& points);

/// @brief Variances of points with all that planes are allowed, turned by the angle and seen at a slant, over what their
/// weights tell.
class ToleratedScale {
 public:
  ToleratedScale(const NearFit& fit, const CoplanarityTolerance& tolerance) : a_(fit.a) {
    const CoplanarityTolerance of_noise = tolerance.forNoise(fit.noise);
    const double turned = of_noise.sigma_angle * fit.radius;
    known2_ = of_noise.sigma_distance * of_noise.sigma_distance;
    allowed2_ = known2_ + turned * turned;
  }
  double operator()(const RegionPoint& point) const {
    const double range2 = point.at.squaredNorm();
    return 1.0 + (allowed2_ * secantSquared(a_, std::sqrt(range2)) - known2_) * point.weight / range2;
  }

 private:
  Eigen::Vector3d a_;
  double known2_, allowed2_;
};

/// @brief Whether chi-square, with errors capped at outliers, is what noise makes it.
/// @param scaleOf what a point's variance is over what its weight tells.
template <typename F>
bool isExplained(const std::vector<RegionPoint>& points, const Eigen::Vector3d& a, const F& scaleOf) {
  double chi2 = 0.0;
  for (const RegionPoint& point : points) {
    chi2 += std::min(RegionPoint::kFarthest2, point.squaredError(a) / scaleOf(point));
  }
  return chi2 <= mostChiSquare(static_cast<double>(points.size()));
}

}  // namespace ppc
