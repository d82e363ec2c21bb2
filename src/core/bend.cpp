// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/bend.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {

Bend bendOf(const RegionSamples& region) {
  constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation
  const Eigen::Vector3d& normal = region.samples.normal;
  const Eigen::Vector3d s = normal.unitOrthogonal(), t = normal.cross(s);
  const QuadraticSums sums = sumQuadratic(region.samples, s, t);
  const QuadraticFit fit = fitQuadratic(sums);
  Bend bend;
  const Eigen::Vector3d turned = (normal - fit.plane[1] * s - fit.plane[2] * t).normalized();
  bend.plane = {turned, turned.dot(region.samples.center + fit.plane[0] * normal)};
  bend.chi2 = sums.total;
  bend.weight = sums.normal(0, 0);
  if (!(fit.weight > 0.0)) return bend;
  bend.excess = std::max(0.0, fit.plane_chi2 - fit.quadratic_chi2);
  bend.amplitude = std::sqrt(bend.excess / fit.weight);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(fit.hessian);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d axis = eigen.eigenvectors().col(k);
    const double width = kUniformWidth * std::sqrt(std::max(0.0, axis.dot(fit.scatter * axis)));
    bend.turn = std::max(bend.turn, std::abs(eigen.eigenvalues()[k]) * width);
  }
  return bend;
}

}  // namespace ppc
