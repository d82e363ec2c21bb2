// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/plane_score.h"

#include "polygon_plane.h"

#include <algorithm>
#include <cmath>

namespace ppc {

namespace {

struct Comparison {
  const PlanarRegion* truth;
  const PlanarRegion* found;
};

PlaneScore scoreOf(const std::vector<Comparison>& comparisons) {
  PlaneScore score;
  for (const Comparison& each : comparisons) {
    if (each.truth == nullptr || each.found == nullptr) continue;
    const Eigen::Vector3d& a = each.truth->plane.normal;
    const Eigen::Vector3d& b = each.found->plane.normal;
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));  // exact for small angles, unlike acos
    const double offset = std::abs(each.found->plane.signedDistance(each.truth->centroid));
    ++score.matched;
    score.mean_normal_error += angle;
    score.mean_offset_error += offset;
    score.worst_normal_error = std::max(score.worst_normal_error, angle);
    score.worst_offset_error = std::max(score.worst_offset_error, offset);
  }
  if (score.matched > 0) {
    score.mean_normal_error /= score.matched;
    score.mean_offset_error /= score.matched;
  }
  return score;
}

}  // namespace

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
