// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/running_plane.h"

namespace ppc {
namespace {

constexpr int kMostGrowth = 16;  // inverse share of its points by which a cluster grows before its plane is fitted anew

double misfitOf(double excess, const Eigen::Vector3d& a, const JoiningPiece& piece, const CoplanarityTolerance& tolerance) {
  return misfit(excess, piece.points / (piece.sigma * piece.sigma), piece.radius, secantSquared(a, piece.range), tolerance);
}

}  // namespace

const PlaneFit& RunningPlane::fit() {
  if (moments_.n != fitted_points_) {
    fit_ = fitPlane(moments_);
    fitted_points_ = moments_.n;
  }
  return fit_;
}

bool RunningPlane::suits(const JoiningPiece& piece, const CoplanarityTolerance& tolerance, double greatest) {
  const double precision = piece.points / (piece.sigma * piece.sigma);
  const double scale = misfitScale(precision, piece.radius, secantSquared(fit_.a, piece.range), tolerance);
  if (surelySuits(piece.moments, piece.fit, scale, greatest)) return true;
  const PlaneFit joint = fitPlane(moments_ + piece.moments);
  return misfitOf(joint.chi2 - fit().chi2 - piece.fit.chi2, joint.a, piece, tolerance) <= greatest;
}

void RunningPlane::join(const Moments& piece) {
  moments_ += piece;
  if ((moments_.n - fitted_points_) * kMostGrowth > fitted_points_) fit();
}

}  // namespace ppc
