// SPDX-License-Identifier: BSD-3-Clause
// The fit along beams, written plainly: double precision, point by point, step by step until nothing moves.
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc::testing_tools {

inline std::vector<int> pixelsOf(const BeamGrid& grid, const LabelImage& labels, std::int32_t id) {
  std::vector<int> pixels;
  for (int i = 0; i < grid.size(); ++i) {
    if (labels.labels[i] == id && grid.valid(i)) pixels.push_back(i);
  }
  return pixels;
}

/// Error of a range [m].
inline double errorAlong(const BeamGrid& grid, int i, const Plane& plane) {
  return grid.range[i] - plane.rangeAlong(grid.origin(i).cast<double>(), grid.direction(i).cast<double>());
}

/// How one point counts in the fit: weight, distance from the plane, and where the point most likely was on the plane.
struct NaiveTerm {
  double w, h;
  Eigen::Vector3d foot;
};

inline NaiveTerm naiveTerm(const BeamGrid& grid, int i, const Plane& plane, double softness) {
  const Eigen::Vector3d u = grid.direction(i).cast<double>(), o = grid.origin(i).cast<double>();
  const Eigen::Vector3d p = o + grid.range[i] * u, met = o + plane.rangeAlong(o, u) * u;
  const double cosine2 = std::pow(plane.normal.dot(u), 2.0), h = plane.signedDistance(p);
  const double along = cosine2 / (cosine2 + softness);
  return {(1.0 + softness) / (cosine2 + softness), h, along * met + (1.0 - along) * (p - h * plane.normal)};
}

/// @brief The plane that minimises the sum of w h^2 of these pixels, without those whose root is above `limit`.
/// @param plane near it.
inline Plane naiveBeamFit(const BeamGrid& grid, const std::vector<int>& pixels, Plane plane, double limit = 1e9,
                          double softness = 0.0) {
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d t1 = plane.normal.unitOrthogonal(), t2 = plane.normal.cross(t1);
    Eigen::Matrix3d equations = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const int i : pixels) {
      const NaiveTerm term = naiveTerm(grid, i, plane, softness);
      if (term.w * term.h * term.h > limit * limit) continue;
      const Eigen::Vector3d row(-t1.dot(term.foot), -t2.dot(term.foot), 1.0);
      equations += term.w * row * row.transpose();
      right += term.w * term.h * row;
    }
    const Eigen::Vector3d step = equations.ldlt().solve(right);
    const Eigen::Vector3d normal = plane.normal + step[0] * t1 + step[1] * t2;
    plane = {normal.normalized(), (plane.d + step[2]) / normal.norm()};
  }
  return plane;
}

/// 2.5 standard deviations of the errors, as their median tells.
inline double naiveLimit(const BeamGrid& grid, const std::vector<int>& pixels, const Plane& plane) {
  std::vector<double> errors;
  for (const int i : pixels) errors.push_back(std::abs(errorAlong(grid, i, plane)));
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  return 2.5 * 1.4826 * errors[errors.size() / 2];
}

inline double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Normalised error squared of a region's plane: chi-square with three degrees of freedom if that is the true one. Of two
/// turns and of the offset where the points are: elsewhere it is not linear in the turns.
inline double normalisedErrorSquared(const PlanarRegion& region, const Plane& truth) {
  const Eigen::Vector3d t1 = truth.normal.unitOrthogonal(), t2 = truth.normal.cross(t1);
  const Eigen::Vector3d there = region.centroid - truth.signedDistance(region.centroid) * truth.normal;
  const Eigen::Vector3d dn = region.plane.normal - truth.normal;
  const Eigen::Vector3d error(t1.dot(dn), t2.dot(dn), region.plane.signedDistance(there));
  Eigen::Matrix<double, 3, 4> to_error = Eigen::Matrix<double, 3, 4>::Zero();
  to_error.block<1, 3>(0, 0) = t1.transpose();
  to_error.block<1, 3>(1, 0) = t2.transpose();
  to_error.block<1, 3>(2, 0) = there.transpose();
  to_error(2, 3) = -1.0;
  const Eigen::Matrix3d covariance = to_error * region.covariance * to_error.transpose();
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace ppc::testing_tools
