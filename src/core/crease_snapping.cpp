// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/crease_snapping.h"

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/ring_crossings.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace ppc {
namespace {

constexpr double kMinSine = 0.087;      // of the angle between two planes: 5 deg
constexpr double kMinIncidence = 0.05;  // cosine: footprints grow no further
constexpr double kLargestReach = 0.3;   // [m]
constexpr int kLargestGap = 3;          // pixels from one label to the next across unlabelled ones
constexpr std::size_t kMinSamples = 8;  // of a border along a crease
constexpr double kLargestAreaChange = 0.25;

// The common line of two planes, and where along it their regions border on each other.
struct Crease {
  Eigen::Vector3d point, direction;
  double reach = 0.0;         // how far from the line a vertex may be moved from [m]
  std::vector<double> along;  // samples of the border, ascending [m]
  double distance(const Eigen::Vector3d& p) const { return (p - point).cross(direction).norm(); }
  double at(const Eigen::Vector3d& p) const { return direction.dot(p - point); }
  Eigen::Vector3d foot(const Eigen::Vector3d& p) const { return point + at(p) * direction; }
  bool near(const Eigen::Vector3d& p) const {
    if (!(distance(p) <= reach)) return false;
    const auto next = std::lower_bound(along.begin(), along.end(), at(p) - reach);
    return next != along.end() && *next <= at(p) + reach;
  }
};

using RegionPair = std::pair<std::int32_t, std::int32_t>;  // ids, ascending
struct BorderPixels {
  int first, second;  // of the regions of the pair
};

using Borders = std::map<RegionPair, std::vector<BorderPixels>>;

// Adds the border of a pixel, `place` pixels of stride `step` into its line, with the label before it, if there is another.
void addBorder(const BeamGrid& grid, const LabelImage& labels, int pixel, int step, int place, Borders& borders) {
  const std::int32_t label = labels.labels[pixel];
  for (int k = 1, i = pixel - step; k <= std::min(place, kLargestGap); ++k, i -= step) {
    const std::int32_t before = labels.labels[i];
    if (before <= 0) continue;
    if (before != label && grid.valid(pixel) && grid.valid(i)) {
      borders[std::minmax(before, label)].push_back(before < label ? BorderPixels{i, pixel} : BorderPixels{pixel, i});
    }
    return;
  }
}

Borders findBorders(const BeamGrid& grid, const LabelImage& labels) {
  Borders borders;
  forEachChange(labels, [&](int pixel, int step, int place) {
    if (labels.labels[pixel] > 0) addBorder(grid, labels, pixel, step, place, borders);
  });
  return borders;
}

// The common line near the border; nothing if the planes are nearly parallel, or the border does not run along their line.
bool makeCrease(const BeamGrid& grid, const std::vector<BorderPixels>& border, const PlanarRegion& a, const PlanarRegion& b,
                double tolerance, double pixel_tolerance, Crease& crease) {
  const Eigen::Vector3d across = a.plane.normal.cross(b.plane.normal);
  const double sine = across.norm();
  if (sine < kMinSine || border.size() < kMinSamples) return false;
  crease.direction = across / sine;
  // The point of both planes nearest to the middle of both regions.
  const Eigen::Vector3d middle = 0.5 * (a.centroid + b.centroid);
  Eigen::Matrix3d planes;
  planes << a.plane.normal.transpose(), b.plane.normal.transpose(), crease.direction.transpose();
  crease.point = planes.partialPivLu().solve(Eigen::Vector3d(a.plane.d, b.plane.d, crease.direction.dot(middle)));
  if (!crease.point.allFinite()) return false;

  const double base = 2.0 * tolerance + 2.0 * std::max(a.rms, b.rms) / sine;
  double footprints = 0.0;
  for (const BorderPixels& pixels : border) {
    const Eigen::Vector3d direction = grid.direction(pixels.first).cast<double>();
    const double step = (grid.direction(pixels.second).cast<double>() - direction).norm();
    const double incidence = std::min(std::abs(a.plane.normal.dot(direction)), std::abs(b.plane.normal.dot(direction)));
    const double footprint = pixel_tolerance * step * grid.range[pixels.first] / std::max(kMinIncidence, incidence);
    const double reach = std::min(kLargestReach, base + footprint);
    const Eigen::Vector3d p = grid.point(pixels.first).cast<double>(), q = grid.point(pixels.second).cast<double>();
    if (crease.distance(p) > reach || crease.distance(q) > reach) continue;
    crease.along.push_back(crease.at(p));
    footprints += footprint;
  }
  if (crease.along.size() < kMinSamples) return false;
  std::sort(crease.along.begin(), crease.along.end());
  crease.reach = std::min(kLargestReach, base + footprints / static_cast<double>(crease.along.size()));
  return true;
}

// Moves the vertices of a ring; those on a line between two others of the same line go.
std::vector<Eigen::Vector3d> snapRing(const std::vector<Eigen::Vector3d>& ring, const std::vector<Crease>& creases) {
  constexpr int kNone = -1, kCorner = -2;
  std::vector<Eigen::Vector3d> moved = ring;
  std::vector<int> line(ring.size(), kNone);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    int nearest = kNone, second = kNone;
    for (int k = 0; k < static_cast<int>(creases.size()); ++k) {
      if (!creases[k].near(ring[i])) continue;
      if (nearest == kNone || creases[k].distance(ring[i]) < creases[nearest].distance(ring[i])) {
        second = std::exchange(nearest, k);
      } else if (second == kNone || creases[k].distance(ring[i]) < creases[second].distance(ring[i])) {
        second = k;
      }
    }
    if (nearest == kNone) continue;
    moved[i] = creases[nearest].foot(ring[i]);
    line[i] = nearest;
    if (second == kNone) continue;
    // Both lines lie in the plane of the ring: they meet unless they are parallel.
    const Crease &a = creases[nearest], &b = creases[second];
    const Eigen::Vector3d across = a.direction.cross(b.direction);
    if (across.norm() < kMinSine) continue;
    const Eigen::Vector3d corner =
        a.point + (b.point - a.point).cross(b.direction).dot(across) / across.squaredNorm() * a.direction;
    if ((corner - ring[i]).norm() > a.reach + b.reach) continue;
    moved[i] = corner;
    line[i] = kCorner;
  }
  const std::size_t n = ring.size();
  // A tooth that sticks out a little farther between two vertices on the line.
  for (std::size_t i = 0; i < n; ++i) {
    const int before = line[i == 0 ? n - 1 : i - 1], after = line[i + 1 == n ? 0 : i + 1];
    if (line[i] != kNone || before < 0 || before != after || creases[before].distance(ring[i]) > 2.0 * creases[before].reach)
      continue;
    moved[i] = creases[before].foot(ring[i]);
    line[i] = before;
  }
  std::vector<Eigen::Vector3d> kept;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i == 0 ? n - 1 : i - 1, after = i + 1 == n ? 0 : i + 1;
    if (line[i] >= 0 && line[before] == line[i] && line[after] == line[i]) continue;
    if (line[i] == kCorner && line[before] == kCorner && (moved[i] - moved[before]).norm() < 4.0 * kRingClearance) continue;
    kept.push_back(moved[i]);
  }
  return kept;
}

using FlatRing = std::vector<Eigen::Vector2d>;

FlatRing flatten(const std::vector<Eigen::Vector3d>& ring, const Plane& plane) {
  const Eigen::Vector3d x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  FlatRing flat;
  for (const Eigen::Vector3d& p : ring) flat.emplace_back(x.dot(p), y.dot(p));
  return flat;
}

// What extractPolygons() promises. Rings are flat, the outer one first.
bool isSound(const std::vector<FlatRing>& rings) {
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (rings[i].size() < 3 || (signedArea(rings[i]) > 0.0) != (i == 0)) return false;
  }
  if (!findCrossings(rings).empty()) return false;
  for (std::size_t i = 1; i < rings.size(); ++i) {
    if (!isInside(rings[i].front(), rings.front())) return false;
    for (std::size_t j = 1; j < rings.size(); ++j) {
      if (j != i && isInside(rings[i].front(), rings[j])) return false;
    }
  }
  return true;
}

void snapPolygon(const Plane& plane, const std::vector<Crease>& creases, PlanarPolygon& polygon) {
  std::vector<FlatRing> rings{flatten(polygon.outer, plane)};
  for (const auto& hole : polygon.holes) rings.push_back(flatten(hole, plane));
  bool changed = false;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    std::vector<Eigen::Vector3d>& ring = i == 0 ? polygon.outer : polygon.holes[i - 1];
    std::vector<Eigen::Vector3d> snapped = snapRing(ring, creases);
    if (snapped == ring) continue;
    FlatRing flat = flatten(snapped, plane);
    const double before = signedArea(rings[i]);
    if (!(std::abs(signedArea(flat) - before) <= kLargestAreaChange * std::abs(before))) continue;
    std::swap(rings[i], flat);
    if (isSound(rings)) {
      ring = std::move(snapped);
      changed = true;
    } else {
      std::swap(rings[i], flat);
    }
  }
  if (!changed) return;
  polygon.area = 0.0;
  for (const FlatRing& ring : rings) polygon.area += signedArea(ring);  // holes turn the other way
}

}  // namespace

void snapCreases(const BeamGrid& grid, const LabelImage& labels, const std::vector<PlanarRegion>& regions, double tolerance,
                 double pixel_tolerance, std::vector<PlanarPolygon>& polygons) {
  std::map<std::int32_t, const PlanarRegion*> by_id;
  for (const PlanarRegion& region : regions) by_id[region.id] = &region;
  std::map<std::int32_t, std::vector<Crease>> creases;
  for (const auto& [ids, border] : findBorders(grid, labels)) {
    const auto a = by_id.find(ids.first), b = by_id.find(ids.second);
    if (a == by_id.end() || b == by_id.end()) continue;
    Crease crease;
    if (!makeCrease(grid, border, *a->second, *b->second, tolerance, pixel_tolerance, crease)) continue;
    creases[ids.first].push_back(crease);
    creases[ids.second].push_back(std::move(crease));
  }
  for (PlanarPolygon& polygon : polygons) {
    const auto found = creases.find(polygon.id);
    if (found != creases.end()) snapPolygon(by_id.at(polygon.id)->plane, found->second, polygon);
  }
}

}  // namespace ppc
