// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "patch_plane_clustering/core/region_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace patch_plane_clustering {
namespace {

constexpr int kMaxSamples = 3000;
constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Bend measureBend(const BeamGrid& grid, const PlanarRegion& region, const std::vector<int>& pixels, const NoiseModel& noise) {
  const Eigen::Vector3d n = region.plane.normal;
  const Eigen::Vector3d s_axis = n.unitOrthogonal();
  const Eigen::Vector3d t_axis = n.cross(s_axis);
  const int stride = std::max(1, static_cast<int>(pixels.size()) / kMaxSamples);
  double spread = 0.0;
  for (std::size_t k = 0; k < pixels.size(); k += stride) {
    spread = std::max(spread, (grid.point(pixels[k]).cast<double>() - region.centroid).squaredNorm());
  }
  const double scale = std::sqrt(spread);  // coordinates of order one keep the normal equations well conditioned
  if (!(scale > 0.0)) return {};
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double total = 0.0, weights = 0.0;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < pixels.size(); k += stride) {
    const int i = pixels[k];
    const Eigen::Vector3d p = grid.point(i).cast<double>() - region.centroid;
    const double s = s_axis.dot(p) / scale, t = t_axis.dot(p) / scale, z = n.dot(p);
    const double cosine = std::max(0.1, -n.dot(grid.direction(i).cast<double>()));
    const double sigma = noise.sigma(grid.range[i]) * cosine;
    if (std::abs(z) > 4.0 * std::max(sigma, region.rms)) continue;
    const double w = stride / (sigma * sigma);
    Vector6 terms;
    terms << 1.0, s, t, s * s, s * t, t * t;
    normal += w * terms * terms.transpose();
    right += w * z * terms;
    total += w * z * z;
    weights += w;
    scatter += w * Eigen::Vector2d(s, t) * Eigen::Vector2d(s, t).transpose();
  }
  if (!(weights > 0.0)) return {};
  const auto ridge = Matrix6::Identity() * (1e-9 * normal.trace());
  const Vector6 quadratic = (normal + ridge).ldlt().solve(right);
  const Eigen::Vector3d linear =
      (normal.topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity() * (1e-9 * normal.trace())).ldlt().solve(right.head<3>());
  Bend bend;
  bend.excess = std::max(0.0, quadratic.dot(right) - linear.dot(right.head<3>()));
  bend.amplitude = std::sqrt(bend.excess / weights);
  scatter /= weights;
  Eigen::Matrix2d hessian;
  hessian << 2.0 * quadratic[3], quadratic[4], quadratic[4], 2.0 * quadratic[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(hessian);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d axis = eigen.eigenvectors().col(k);
    const double width = kUniformWidth * std::sqrt(std::max(0.0, axis.dot(scatter * axis)));
    bend.turn = std::max(bend.turn, std::abs(eigen.eigenvalues()[k]) * width / scale);
  }
  return bend;
}

}  // namespace

std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  const std::vector<PlanarRegion> regions = describeRegions(grid, labels);
  const std::int32_t highest = regions.empty() ? 0 : regions.back().id;
  std::vector<std::vector<int>> pixels(static_cast<std::size_t>(highest) + 1);
  for (const PlanarRegion& region : regions) pixels[region.id].reserve(region.points);
  for (int i = 0; i < grid.size(); ++i) {
    const std::int32_t label = labels.labels[i];
    if (label > 0 && label <= highest && grid.valid(i)) pixels[label].push_back(i);
  }
  std::vector<Bend> bends(pixels.size());
  for (const PlanarRegion& region : regions) bends[region.id] = measureBend(grid, region, pixels[region.id], noise);
  return bends;
}

void dropCurvedRegions(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                       LabelImage& labels) {
  constexpr double kSignificance = 25.0;  // far beyond chi-square with 3 degrees of freedom
  const std::vector<Bend> bends = measureBends(grid, labels, noise);
  const double floor = 0.5 * tolerance.sigma_distance;
  for (std::int32_t& label : labels.labels) {
    if (label <= 0 || label >= static_cast<std::int32_t>(bends.size())) continue;
    const Bend& bend = bends[label];
    if (bend.turn > max_turn && bend.amplitude > floor && bend.excess > kSignificance * tolerance.inflation) label = 0;
  }
}

}  // namespace patch_plane_clustering
