// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/across_fit.h"

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/point_lanes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

// Calls f(beams) for pixels [begin, end), four at a time.
template <typename F>
void forEachBeams(const BeamGrid& grid, int begin, int end, const F& f) {
  int i = begin;
  for (; i + kLanes <= end; i += kLanes) f(BeamLanes(grid, i));
  if (i < end) f(BeamLanes(grid, i, end - i));
}

}  // namespace

PointSums& PointSums::operator+=(const PointSums& o) {
  ux += o.ux;
  uy += o.uy;
  uz += o.uz;
  x += o.x;
  y += o.y;
  z += o.z;
  xx += o.xx;
  xy += o.xy;
  xz += o.xz;
  yy += o.yy;
  yz += o.yz;
  zz += o.zz;
  n += o.n;
  return *this;
}

// Four at a time in single precision about the block's own first point, which is near enough for the digits to suffice.
void addPoints(const BeamGrid& grid, int begin, int end, const Eigen::Vector3d& origin, PointSums& s) {
  while (begin < end && !grid.valid(begin)) ++begin;
  if (begin == end) return;
  const Eigen::Vector3f first = grid.point(begin);
  PointLanes q;
  LaneMask counted = {};
  forEachBeams(grid, begin, end, [&](const BeamLanes& beam) {
    const Lanes zero = {};
    const Lanes px = beam.valid ? beam.origin_x + beam.range * beam.dir_x - first.x() : zero;
    const Lanes py = beam.valid ? beam.origin_y + beam.range * beam.dir_y - first.y() : zero;
    const Lanes pz = beam.valid ? beam.origin_z + beam.range * beam.dir_z - first.z() : zero;
    q.add(px, py, pz);
    counted += beam.valid;
  });
  // From the block's origin to the label's: p = q + (first - o).
  const double n = countLanes(counted);
  const double dx = first.x() - origin.x(), dy = first.y() - origin.y(), dz = first.z() - origin.z();
  const double qx = sumLanes(q.x), qy = sumLanes(q.y), qz = sumLanes(q.z);
  s.ux += n * grid.dir_x[begin];
  s.uy += n * grid.dir_y[begin];
  s.uz += n * grid.dir_z[begin];
  s.x += qx + n * dx;
  s.y += qy + n * dy;
  s.z += qz + n * dz;
  s.xx += sumLanes(q.xx) + 2.0 * qx * dx + n * dx * dx;
  s.xy += sumLanes(q.xy) + qx * dy + qy * dx + n * dx * dy;
  s.xz += sumLanes(q.xz) + qx * dz + qz * dx + n * dx * dz;
  s.yy += sumLanes(q.yy) + 2.0 * qy * dy + n * dy * dy;
  s.yz += sumLanes(q.yz) + qy * dz + qz * dy + n * dy * dz;
  s.zz += sumLanes(q.zz) + 2.0 * qz * dz + n * dz * dz;
  s.n += static_cast<int>(n);
}

PlanarRegion fitAcross(std::int32_t id, const Eigen::Vector3d& origin, const PointSums& s) {
  PlanarRegion region;
  region.id = id;
  region.points = s.n;
  const double n = s.n;
  const Eigen::Vector3d mean = Eigen::Vector3d(s.x, s.y, s.z) / n;
  region.centroid = origin + mean;
  Eigen::Matrix3d outer;
  outer << s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz;
  const Eigen::Matrix3d scatter = outer - n * mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.dot(Eigen::Vector3d(s.ux, s.uy, s.uz)) > 0.0) normal = -normal;
  region.plane = {normal, normal.dot(region.centroid)};
  region.rms = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / n);

  // Rotations about the in-plane axes and the offset at the centroid are independent; d follows from both. For residuals of
  // unit variance: theirs follows.
  Eigen::Matrix<double, 4, 3> jacobian = Eigen::Matrix<double, 4, 3>::Zero();
  Eigen::Vector3d variances(0.0, 0.0, 1.0 / n);
  for (int k = 1; k <= 2; ++k) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(k);
    jacobian.block<3, 1>(0, k - 1) = axis;
    jacobian(3, k - 1) = axis.dot(region.centroid);
    variances[k - 1] = eigen.eigenvalues()[k] > 0.0 ? 1.0 / eigen.eigenvalues()[k] : 0.0;
  }
  jacobian(3, 2) = 1.0;
  region.covariance = jacobian * variances.asDiagonal() * jacobian.transpose();
  return region;
}

}  // namespace ppc
