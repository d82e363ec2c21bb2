// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace patch_plane_clustering {
namespace {

struct PointSums {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // first point: sums about it keep their digits far from the sensor
  Eigen::Vector3d beams = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  int n = 0;
};

PlanarRegion describe(std::int32_t id, const PointSums& s) {
  PlanarRegion region;
  region.id = id;
  region.points = s.n;
  const double n = s.n;
  const Eigen::Vector3d mean = s.sum / n;
  region.centroid = s.origin + mean;
  const Eigen::Matrix3d scatter = s.outer - n * mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.dot(s.beams) > 0.0) normal = -normal;
  region.plane = {normal, normal.dot(region.centroid)};
  const double residual = std::max(0.0, eigen.eigenvalues()[0]);
  region.rms = std::sqrt(residual / n);

  // Rotations about the in-plane axes and the offset at the centroid are independent; d follows from both.
  const double variance = residual / std::max(1.0, n - 3.0);
  Eigen::Matrix<double, 4, 3> jacobian = Eigen::Matrix<double, 4, 3>::Zero();
  Eigen::Vector3d variances(0.0, 0.0, variance / n);
  for (int k = 1; k <= 2; ++k) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(k);
    jacobian.block<3, 1>(0, k - 1) = axis;
    jacobian(3, k - 1) = axis.dot(region.centroid);
    variances[k - 1] = eigen.eigenvalues()[k] > 0.0 ? variance / eigen.eigenvalues()[k] : 0.0;
  }
  jacobian(3, 2) = 1.0;
  region.covariance = jacobian * variances.asDiagonal() * jacobian.transpose();
  return region;
}

}  // namespace

std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels) {
  std::int32_t highest = 0;
  for (const std::int32_t label : labels.labels) highest = std::max(highest, label);
  std::vector<PointSums> sums(static_cast<std::size_t>(highest) + 1);
  for (int i = 0; i < grid.size(); ++i) {
    const std::int32_t label = labels.labels[i];
    if (label <= 0 || !grid.valid(i)) continue;
    PointSums& s = sums[label];
    const Eigen::Vector3d p = grid.point(i).cast<double>();
    if (s.n++ == 0) s.origin = p;
    const Eigen::Vector3d q = p - s.origin;
    s.beams += grid.direction(i).cast<double>();
    s.sum += q;
    s.outer += q * q.transpose();
  }
  std::vector<PlanarRegion> regions;
  for (std::int32_t id = 1; id <= highest; ++id) {
    if (sums[id].n >= 3) regions.push_back(describe(id, sums[id]));
  }
  return regions;
}

int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels) {
  std::int32_t highest = 0;
  for (const std::int32_t label : labels.labels) highest = std::max(highest, label);
  std::vector<int> count(static_cast<std::size_t>(highest) + 1, 0);
  std::vector<int> first(count.size(), grid.size());
  for (int i = grid.size() - 1; i >= 0; --i) {
    std::int32_t& label = labels.labels[i];
    if (!grid.valid(i) || label < 0) label = 0;
    ++count[label];
    first[label] = i;
  }
  std::vector<std::int32_t> order(static_cast<std::size_t>(highest));
  std::iota(order.begin(), order.end(), 1);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return count[a] != count[b] ? count[a] > count[b] : first[a] < first[b];
  });
  std::vector<std::int32_t> renamed(count.size(), 0);
  int n = 0;
  for (const std::int32_t label : order) {
    if (count[label] >= std::max(1, min_size)) renamed[label] = ++n;
  }
  for (std::int32_t& label : labels.labels) label = renamed[label];
  return n;
}

}  // namespace patch_plane_clustering
