// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/similarity.h"

namespace ppc {

/// @brief A piece of surface that may join a cluster.
struct JoiningPiece {
  const Moments& moments;
  const PlaneFit& fit;
  double radius;  ///< [m]
  double range;   ///< [m]
  double sigma;   ///< noise of a range there [m]
  double points;  ///< that its noise averages out over
};

/// @brief The plane of a cluster while it grows, piece by piece. Not thread-safe.
///
/// A piece is compared by the misfit of the joint plane (similarity.h). Most pieces of a wall lie so close to the plane as
/// it is that the joint one need not be found: what the piece alone costs on that plane is at least what the joint plane
/// costs over the two. Such a piece joins at once, and the plane is fitted anew only when the cluster has grown by a
/// sixteenth or a piece asks for it.
class RunningPlane {
 public:
  RunningPlane(const Moments& moments, const PlaneFit& fit) : moments_(moments), fit_(fit), fitted_points_(moments.n) {}

  const Moments& moments() const { return moments_; }
  /// The plane of all pieces that have joined.
  const PlaneFit& fit();

  /// About the plane of all: it may lag behind.
  const Eigen::Vector3d& about() const { return fit_.a; }

  /// Whether the misfit of a piece is plainly less than `greatest` on that plane. @param scale the denominator of misfit()
  /// there.
  bool surelySuits(const Moments& moments, const PlaneFit& fit, double scale, double greatest) const {
    constexpr double kSurely = 0.7;  // of the greatest misfit: leaves room for a plane that lags behind
    return moments_.n > moments.n && chiSquare(moments, fit_.a) - fit.chi2 < kSurely * greatest * scale;
  }

  /// Whether the misfit of a piece is at most `greatest`.
  bool suits(const JoiningPiece& piece, const CoplanarityTolerance& tolerance, double greatest);
  void join(const Moments& piece);

 private:
  Moments moments_;
  PlaneFit fit_;  // of fitted_points_
  int fitted_points_;
};

}  // namespace ppc
