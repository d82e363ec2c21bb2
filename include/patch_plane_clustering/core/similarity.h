// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/moments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {

/// @brief What "coplanar" may mean on real walls and real sensors, beyond the noise of single ranges.
struct CoplanarityTolerance {
  double sigma_distance = 0.005;  ///< how far a piece of a plane may stand off the rest of it [m]
  double sigma_angle = 0.02;      ///< how far it may be turned against the rest [rad]
  double inflation = 1.0;         ///< variance of a patch's plane over that of white noise (correlated errors) [1]
  double inflation_growth = 0.0;  ///< exponent of its growth beyond patch_points: 0 white noise, 1 never averages out
  double patch_points = 20.0;     ///< of such a patch
  double least_distance = 0.0;    ///< of sigma_distance, what stays however fine the sensor: errors of whole lines [m]
  bool alike_around = false;      ///< errors are correlated along rows and along columns, see areErrorsAlikeAround()

  /// Inflation of the plane of n points: errors correlated farther than over a patch average out still more slowly.
  double inflationOf(double n) const {
    return inflation_growth > 0.0 && n > patch_points ? inflation * std::pow(n / patch_points, inflation_growth) : inflation;
  }

  /// Whether errors are independent from point to point, as far as an image can tell.
  bool isWhite() const {
    constexpr double kWhite = 1.2;  // inflation that white noise may show
    return inflation < kWhite && inflation_growth == 0.0;
  }

  /// Whether errors are alike over more points than a patch has, so that bumps of noise look like surfaces.
  bool isSmooth() const { return inflation_growth > 0.0; }

  /// Whether a sensor is so fine that its tolerance shrinks with its noise `sigma` [m].
  bool isFine(double sigma) const { return forNoise(sigma).sigma_distance < sigma_distance; }

  /// @brief The tolerance where ranges have the noise `sigma` [m]. The errors that it stands for, of calibration, grid and
  /// bias, shrink with the noise: a sensor that resolves a millimetre shall tell a step of five from a plane.
  CoplanarityTolerance forNoise(double sigma) const {
    constexpr double kCoarse = 0.0025;  // noise from which on the whole distance applies [m]
    constexpr double kLeast = 0.3;      // share of the distance that remains for the finest sensor
    CoplanarityTolerance scaled = *this;
    scaled.sigma_distance = std::max(least_distance, sigma_distance * std::clamp(sigma / kCoarse, kLeast, 1.0));
    return scaled;
  }
};

/// The denominator of misfit().
inline double misfitScale(double precision, double radius, double sec2, const CoplanarityTolerance& tolerance) {
  const double turned = tolerance.sigma_angle * radius;
  const double tau2 = (tolerance.sigma_distance * tolerance.sigma_distance + turned * turned) * sec2;
  return 3.0 * tolerance.inflation + precision * tau2;
}

/// @brief Misfit of the coplanarity conditions: twice the negative logarithm of similarity(), whose parameters it shares.
inline double misfit(double excess, double precision, double radius, double sec2, const CoplanarityTolerance& tolerance) {
  return std::max(0.0, excess) / misfitScale(precision, radius, sec2, tolerance);
}

/// @brief Gaussian similarity of the coplanarity conditions of two pieces of surface, in (0, 1].
///
/// Two pieces are coplanar if one plane serves both: the same distance and no angle between them. The misfit of these
/// conditions, each weighed with its covariance, is what the joint fit costs over the two single fits,
///     dE = chi2(a + b) - chi2(a) - chi2(b),
/// a squared Mahalanobis distance with 3 degrees of freedom. The similarity is
///     S = exp(-1/2 dE / (3 inflation + n tau^2 / sigma^2)),   tau^2 = (sigma_distance^2 + (sigma_angle L)^2) /
///     cos^2(incidence),
/// with n, L and sigma the points, radius and noise of the smaller piece: noise averages out over n points, whereas tau, the
/// user's tolerance, does not. This is our own reading of the Gaussian of Kaushik & Xiao (2012); with one point per
/// piece or a large tau it becomes exp(-1/2 (distance / tau)^2).
/// @param excess dE. @param precision n / sigma^2 of the smaller piece [1/m^2]. @param radius L [m].
/// @param sec2 1 / cos^2 of the angle of incidence there: tolerances are across the surface, ranges along the beam.
inline double similarity(double excess, double precision, double radius, double sec2,
                         const CoplanarityTolerance& tolerance) {
  return std::exp(-0.5 * misfit(excess, precision, radius, sec2, tolerance));
}

/// The misfit at which the similarity has fallen to `threshold`: comparing misfits saves the exponential.
inline double greatestMisfit(double threshold) { return -2.0 * std::log(threshold); }

/// @brief The same without any notion of noise, as in the plain algorithm: S = exp(-1/2 ((angle / sigma_angle)^2 + (distance
/// / sigma_distance)^2)), with the angle between two planes and their distance at one point, along their normals.
/// @param a,b the planes a . p = 1, b . p = 1. @param at the point, about where the two pieces meet [m].
inline double fixedSimilarity(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& at,
                              const CoplanarityTolerance& tolerance) {
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b)) / tolerance.sigma_angle;
  const double distance = ((a.dot(at) - 1.0) / a.norm() - (b.dot(at) - 1.0) / b.norm()) / tolerance.sigma_distance;
  return std::exp(-0.5 * (angle * angle + distance * distance));
}

/// The largest 1 / cos^2 that a tolerance is widened by.
constexpr double kMaxSecant2 = 30.0;

/// @brief 1 / cos^2 of the angle between the beam to a point at `range` [m] on the plane a . p = 1 and its normal, limited
/// so that a grazing surface does not become similar to everything.
inline double secantSquared(const Eigen::Vector3d& a, double range) {
  return std::clamp(a.squaredNorm() * range * range, 1.0, kMaxSecant2);
}

}  // namespace ppc
