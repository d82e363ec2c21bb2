// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/boundary_score.h"

#include "patch_plane_clustering/evaluation/hole_score.h"
#include "polygon_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {
namespace {

constexpr double kMinSine = 0.0523;  // of the angle between beam and plane: 3 deg

double distanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double distanceToRing(const Eigen::Vector3d& p, const std::vector<Eigen::Vector3d>& ring) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    nearest = std::min(nearest, distanceToSegment(p, ring[i], ring[(i + 1) % ring.size()]));
  }
  return nearest;
}

}  // namespace

std::vector<Eigen::Vector3d> trueOutline(const BeamGrid& beams, const LabelImage& truth, const PlanarRegion& region,
                                         int min_hole) {
  std::vector<char> inside(truth.labels.size(), 0);
  for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = truth.labels[i] == region.id ? 1 : 0;
  for (const Hole& hole : holesOf(truth, region.id, 1)) {
    if (static_cast<int>(hole.size()) >= min_hole) continue;
    for (const int i : hole) inside[i] = 1;
  }
  std::vector<Eigen::Vector3d> outline;
  const auto cast = [&](const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    const Eigen::Vector3d u = direction.cast<double>().normalized();
    if (std::abs(u.dot(region.plane.normal)) < kMinSine) return;
    const Eigen::Vector3d from = origin.cast<double>();
    const double range = region.plane.rangeAlong(from, u);
    if (range > 0.0) outline.emplace_back(from + range * u);
  };
  for (int r = 0; r < truth.rows; ++r) {
    for (int c = 0; c < truth.cols; ++c) {
      const int i = beams.index(r, c);
      if (inside[i] == 0) continue;
      const auto side = [&](int dr, int dc) {
        const auto within = [&](int row, int col) { return row >= 0 && row < truth.rows && col >= 0 && col < truth.cols; };
        if (within(r + dr, c + dc)) {
          const int j = beams.index(r + dr, c + dc);
          if (inside[j] == 0) cast((beams.origin(i) + beams.origin(j)) / 2.0F, beams.direction(i) + beams.direction(j));
        } else if (within(r - dr, c - dc)) {  // continue the step from the other side by a half
          const int j = beams.index(r - dr, c - dc);
          cast(beams.origin(i), 3.0F * beams.direction(i) - beams.direction(j));
        }
      };
      side(-1, 0);
      side(1, 0);
      side(0, -1);
      side(0, 1);
    }
  }
  return outline;
}

BoundaryScore boundaryScore(const BeamGrid& beams, const LabelImage& truth, const std::vector<PlanarRegion>& truth_planes,
                            const std::vector<PlanarPolygon>& polygons, const RegionOverlap& overlap,
                            const SegcompScore& matches) {
  BoundaryScore score;
  for (const auto& [t, f] : matches.matches) {
    const PlanarRegion* region = regionById(truth_planes, overlap.true_ids[t]);
    if (region == nullptr) continue;
    std::vector<const std::vector<Eigen::Vector3d>*> rings;
    for (const PlanarPolygon& polygon : polygons) {
      if (polygon.id != overlap.found_ids[f]) continue;
      rings.push_back(&polygon.outer);
      for (const auto& hole : polygon.holes) rings.push_back(&hole);
    }
    const std::vector<Eigen::Vector3d> outline = trueOutline(beams, truth, *region);
    if (rings.empty() || outline.empty()) continue;
    double sum = 0.0;
    for (const Eigen::Vector3d& p : outline) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto* ring : rings) nearest = std::min(nearest, distanceToRing(p, *ring));
      sum += nearest;
    }
    score.mean_error += sum / static_cast<double>(outline.size());
    ++score.regions;
  }
  if (score.regions > 0) score.mean_error /= score.regions;
  return score;
}

}  // namespace ppc
