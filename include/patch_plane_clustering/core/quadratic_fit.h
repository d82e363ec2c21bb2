// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace ppc {

/// @brief Samples of a surface near a plane of its own: columns of numbers in someone else's memory. Columns are whole lanes
/// (a multiple of kLanes) long: fill up with samples of weight 0.
struct SurfaceSamples {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< on the plane; the points are about it [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  float *x = nullptr, *y = nullptr, *z = nullptr;  ///< on the plane: where its beam meets it, or below it [m]
  float* height = nullptr;                         ///< of what was measured over the plane, along the normal [m]
  float* weight = nullptr;                         ///< 1 / variance of the height [1/m^2]; 0: left out
  std::size_t size = 0;                            ///< of a column
  int used = 0;                                    ///< samples of a weight above 0

  static constexpr std::size_t kColumns = 5;
  /// Lays the columns out in room for kColumns * length numbers.
  void place(float* room, std::size_t length) {
    x = room;
    y = x + length;
    z = y + length;
    height = z + length;
    weight = height + length;
    size = length;
  }
};

/// @brief Normal equations of weighted least squares  z(s, t) = c . (1, s, t, s^2, s t, t^2)  about an origin. Those of
/// several groups of samples add, once they are about one origin and one base.
struct QuadraticSums {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();  ///< sum w m m^T of the terms m
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();   ///< sum w m z
  double total = 0.0;                                                        ///< sum w z^2
  int used = 0;                                                              ///< samples

  QuadraticSums& operator+=(const QuadraticSums& o);
};

/// @brief Sums of samples in the frame of two tangents s and t and their cross product n, about the samples' own center,
/// and with z (along n) from their own plane: small numbers, so that single precision holds all digits that matter.
/// Precondition: n is not in the samples' plane. @param of_groups one in so many groups of kLanes samples counts.
QuadraticSums sumQuadratic(const SurfaceSamples& samples, const Eigen::Vector3d& s_axis, const Eigen::Vector3d& t_axis,
                           int of_groups = 1);

/// @brief The same about another origin, with z from the plane through that origin and perpendicular to n.
QuadraticSums sumQuadraticAbout(const Eigen::Vector3d& origin, const SurfaceSamples& samples, const Eigen::Vector3d& s_axis,
                                const Eigen::Vector3d& t_axis, int of_groups = 1);

/// @brief Least-squares plane and quadratic surface.
struct QuadraticFit {
  double plane_chi2 = 0.0, quadratic_chi2 = 0.0;
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();    // z = c0 [m] + c1 s + c2 t
  double weight = 0.0;                                // sum of 1 / sigma^2 [1/m^2]
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();  // [1/m]
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();  // weighted covariance of (s, t) about the origin [m^2]
};

/// @brief Solves the normal equations. Of fewer than six samples, or samples at one point: all zero.
QuadraticFit fitQuadratic(const QuadraticSums& sums);

}  // namespace ppc
