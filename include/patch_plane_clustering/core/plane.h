// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace ppc {

/// @brief Plane in Hessian normal form: normal . p = d, |normal| = 1, normal towards the sensor (so d < 0 when the sensor is
/// at the origin). shape_msgs/Plane stores a x + b y + c z + e = 0: its fourth coefficient is -d.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double d = 0.0;  ///< [m]

  /// Signed distance of a point, positive on the sensor's side [m].
  double signedDistance(const Eigen::Vector3d& p) const { return normal.dot(p) - d; }

  /// Distance along the beam from `origin` in unit direction `dir` to the plane [m]; not finite or negative if it misses.
  double rangeAlong(const Eigen::Vector3d& origin, const Eigen::Vector3d& dir) const {
    return (d - normal.dot(origin)) / normal.dot(dir);
  }
};

}  // namespace ppc
