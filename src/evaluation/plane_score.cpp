// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/plane_score.h"

#include "polygon_plane.h"

#include <algorithm>
#include <cmath>

namespace ppc {

PlaneScore planeScore(const std::vector<PlanarRegion>& truth, const std::vector<PlanarRegion>& found,
                      const RegionOverlap& overlap, const SegcompScore& matches) {
  PlaneScore score;
  for (const auto& [t, f] : matches.matches) {
    const PlanarRegion* true_region = regionById(truth, overlap.true_ids[t]);
    const PlanarRegion* found_region = regionById(found, overlap.found_ids[f]);
    if (true_region == nullptr || found_region == nullptr) continue;
    const Eigen::Vector3d& a = true_region->plane.normal;
    const Eigen::Vector3d& b = found_region->plane.normal;
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));  // exact for small angles, unlike acos
    const double offset = std::abs(found_region->plane.signedDistance(true_region->centroid));
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

}  // namespace ppc
