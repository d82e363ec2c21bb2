// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/bend.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {

Bend bendOf(const RegionSamples& region) {
  constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation
  const Eigen::Vector3d s = region.plane.normal.unitOrthogonal();
  const QuadraticSums sums = sumQuadratic(region.samples, s, region.plane.normal.cross(s));
  const QuadraticFit fit = fitQuadratic(sums);
  Bend bend;
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
