// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/plane_score.h"

#include "patch_plane_clustering/core/quantile.h"
#include "polygon_plane.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {

namespace {

constexpr double kChiSquare3At95 = 7.8147;

struct Comparison {
  const PlanarRegion* truth;
  const PlanarRegion* found;
};

PlaneScore scoreOf(const std::vector<Comparison>& comparisons) {
  PlaneScore score;
  std::vector<double> normalised;
  for (const Comparison& each : comparisons) {
    if (each.truth == nullptr || each.found == nullptr) continue;
    const Eigen::Vector3d& a = each.truth->plane.normal;
    const Eigen::Vector3d& b = each.found->plane.normal;
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));  // exact for small angles, unlike acos
    const double offset = std::abs(each.found->plane.signedDistance(each.truth->centroid));
    normalised.push_back(normalisedErrorSquared(*each.truth, *each.found));
    ++score.matched;
    score.mean_normal_error += angle;
    score.mean_offset_error += offset;
    score.worst_normal_error = std::max(score.worst_normal_error, angle);
    score.worst_offset_error = std::max(score.worst_offset_error, offset);
  }
  if (score.matched > 0) {
    score.mean_normal_error /= score.matched;
    score.mean_offset_error /= score.matched;
    score.median_normalised_error = median(normalised);
    const auto within = std::count_if(normalised.begin(), normalised.end(), [](double e) { return e <= kChiSquare3At95; });
    score.within_95 = static_cast<double>(within) / score.matched;
  }
  return score;
}

}  // namespace

double normalisedErrorSquared(const PlanarRegion& truth, const PlanarRegion& found) {
  const Eigen::Vector3d& n = truth.plane.normal;
  const Eigen::Vector3d there = truth.centroid - truth.plane.signedDistance(truth.centroid) * n;
  const Eigen::Vector3d t1 = n.unitOrthogonal(), t2 = n.cross(t1);
  const Eigen::Vector3d turned = found.plane.normal - n;
  const Eigen::Vector3d error(t1.dot(turned), t2.dot(turned), found.plane.signedDistance(there));
  Eigen::Matrix<double, 3, 4> to_error = Eigen::Matrix<double, 3, 4>::Zero();
  to_error.block<1, 3>(0, 0) = t1.transpose();
  to_error.block<1, 3>(1, 0) = t2.transpose();
  to_error.block<1, 3>(2, 0) = there.transpose();
  to_error(2, 3) = -1.0;
  const Eigen::LLT<Eigen::Matrix3d> covariance(to_error * found.covariance * to_error.transpose());
  const double squared = error.dot(covariance.solve(error));
  return covariance.info() == Eigen::Success && std::isfinite(squared) ? squared : std::numeric_limits<double>::infinity();
}

PlaneScore planeScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& found,
                      const RegionOverlap& overlap, const SegcompScore& matches) {
  std::vector<Comparison> all;
  for (const auto& [t, f] : matches.matches) {
    all.push_back({regionById(truth, overlap.true_ids[t]), regionById(found, overlap.found_ids[f])});
  }
  return scoreOf(all);
}

PlaneScore refitScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& refits,
                      const RegionOverlap& overlap, const SegcompScore& matches) {
  std::vector<Comparison> all;
  for (const auto& match : matches.matches) {
    const std::int32_t id = overlap.true_ids[match.first];
    all.push_back({regionById(truth, id), regionById(refits, id)});
  }
  return scoreOf(all);
}

}  // namespace ppc
