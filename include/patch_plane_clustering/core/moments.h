// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace ppc {

/// @brief Weighted moments of points seen from a sensor near the origin, for plane fits whose residuals run along the beams.
///
/// A plane n . p = d is written a . p = 1 with a = n / d. In inverse range it is linear, 1/r = a . (p/r) (Badino et al.
/// 2011), so with the variance of 1/r, sigma^2 / r^4, least squares minimises  sum w (1 - a . p)^2,  w = (r / sigma)^2. Its
/// minimum is chi-square distributed with n - 3 degrees of freedom for white range noise. Moments of regions add. Planes
/// through the origin cannot be represented; the origin must be the (mean) sensor position.
struct Moments {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  ///< sum w p p^T
  double x = 0, y = 0, z = 0;                             ///< sum w p
  double w = 0;                                           ///< sum w
  int n = 0;                                              ///< points

  void add(double px, double py, double pz, double weight) {
    const double wx = weight * px, wy = weight * py, wz = weight * pz;
    xx += wx * px;
    xy += wx * py;
    xz += wx * pz;
    yy += wy * py;
    yz += wy * pz;
    zz += wz * pz;
    x += wx;
    y += wy;
    z += wz;
    w += weight;
    ++n;
  }

  Moments& operator+=(const Moments& o) { return combine(o, 1.0, o.n); }
  Moments& operator-=(const Moments& o) { return combine(o, -1.0, -o.n); }

  /// Multiplies all weights by a factor.
  void scale(double factor) {
    for (double* sum : {&xx, &xy, &xz, &yy, &yz, &zz, &x, &y, &z, &w}) *sum *= factor;
  }

  /// Weighted mean of the points [m].
  Eigen::Vector3d mean() const { return Eigen::Vector3d(x, y, z) / std::max(w, 1e-300); }

  /// Weighted root mean square distance of the points from their mean [m].
  double radius() const { return std::sqrt(std::max(0.0, (xx + yy + zz) / w - mean().squaredNorm())); }

 private:
  Moments& combine(const Moments& o, double sign, int count) {
    xx += sign * o.xx;
    xy += sign * o.xy;
    xz += sign * o.xz;
    yy += sign * o.yy;
    yz += sign * o.yz;
    zz += sign * o.zz;
    x += sign * o.x;
    y += sign * o.y;
    z += sign * o.z;
    w += sign * o.w;
    n += count;
    return *this;
  }
};

inline Moments operator+(Moments a, const Moments& b) { return a += b; }

/// @brief Least-squares plane of moments: a = n / d in the moments' coordinates, and the chi-square of its residuals.
struct PlaneFit {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  ///< [1/m]; normal towards the sensor is -a / |a|
  double chi2 = 0.0;

  double distance() const { return 1.0 / a.norm(); }          ///< of the plane from the sensor [m]
  Eigen::Vector3d normal() const { return -a.normalized(); }  ///< towards the sensor
};

/// @brief Solution of the normal equations of a plane fit. @tparam T double, or a vector of them for several fits at a time.
template <typename T>
struct PlaneSolution {
  T ax, ay, az, chi2;
};

/// @brief Solves the 3 x 3 normal equations by a square-root-free Cholesky factorisation, L D L^T: three divisions, one
/// waiting for the other, are all that holds it up. Directions that the points do not determine (a line, one point) get the
/// smallest solution, through a ridge far below the noise of any real patch.
/// @param m with the members xx to zz, x, y, z and w of Moments, of type T.
template <typename T, typename Sums>
PlaneSolution<T> solvePlane(const Sums& m) {
  const T ridge = 1e-10 * (m.xx + m.yy + m.zz) + 1e-300;
  const T inverse0 = 1.0 / (m.xx + ridge);
  const T l10 = m.xy * inverse0, l20 = m.xz * inverse0;
  const T pivot1 = m.yy + ridge - l10 * m.xy;
  const T inverse1 = 1.0 / (pivot1 < ridge ? ridge : pivot1);
  const T rest21 = m.yz - l20 * m.xy;
  const T l21 = rest21 * inverse1;
  const T pivot2 = m.zz + ridge - l20 * m.xz - l21 * rest21;
  const T inverse2 = 1.0 / (pivot2 < ridge ? ridge : pivot2);
  const T y1 = m.y - l10 * m.x;  // L y = right-hand side; its first entry is m.x
  const T y2 = m.z - l20 * m.x - l21 * y1;
  const T z0 = m.x * inverse0, z1 = y1 * inverse1, z2 = y2 * inverse2;
  PlaneSolution<T> out;
  out.az = z2;
  out.ay = z1 - l21 * z2;
  out.ax = z0 - l10 * out.ay - l20 * z2;
  const T chi2 = m.w - m.x * z0 - y1 * z1 - y2 * z2;
  out.chi2 = chi2 < T{} ? T{} : chi2;
  return out;
}

inline PlaneFit fitPlane(const Moments& m) {
  const PlaneSolution<double> solution = solvePlane<double>(m);
  return {Eigen::Vector3d(solution.ax, solution.ay, solution.az), solution.chi2};
}

/// @brief Chi-square of the points of `m` against a given plane.
inline double chiSquare(const Moments& m, const Eigen::Vector3d& a) {
  const double quadratic = a.x() * (a.x() * m.xx + 2.0 * (a.y() * m.xy + a.z() * m.xz)) +
                           a.y() * (a.y() * m.yy + 2.0 * a.z() * m.yz) + a.z() * a.z() * m.zz;
  return std::max(0.0, m.w - 2.0 * (a.x() * m.x + a.y() * m.y + a.z() * m.z) + quadratic);
}

}  // namespace ppc
