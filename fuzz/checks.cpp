// SPDX-License-Identifier: BSD-3-Clause
#include "checks.h"

#include "patch_plane_clustering/core/segmenter.h"
#include "patch_plane_clustering/evaluation/polygon_score.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"
#include "patch_plane_clustering/ros/triangulation.h"

#include <algorithm>
#include <cmath>

namespace ppc::fuzz {
namespace {

constexpr int kRepeated = 400;  // grids of no more pixels are segmented twice

std::string at(const char* what, std::int32_t id) { return std::string(what) + ", region " + std::to_string(id); }

// Ids are 1..N in order, which is checked before polygons are.
const PlanarRegion& regionOf(const PlanarPolygon& polygon, const std::vector<PlanarRegion>& regions) {
  require(polygon.id >= 1 && static_cast<std::size_t>(polygon.id) <= regions.size(),
          at("polygon without region", polygon.id));
  return regions[static_cast<std::size_t>(polygon.id) - 1];
}

void checkRegion(const PlanarRegion& region) {
  require(std::abs(region.plane.normal.norm() - 1.0) < 1e-6, at("normal is not a unit vector", region.id));
  require(std::isfinite(region.plane.d), at("d is not finite", region.id));
  require(region.centroid.allFinite(), at("centroid is not finite", region.id));
  require(std::isfinite(region.rms) && region.rms >= 0.0, at("rms is negative or not finite", region.id));
  require(region.covariance.allFinite() && region.covariance.diagonal().minCoeff() >= 0.0,
          at("covariance is not finite or has a negative variance", region.id));
}

void checkRing(const std::vector<Eigen::Vector3d>& ring, const Plane& plane, std::int32_t id) {
  require(ring.size() >= 3, at("ring of fewer than 3 vertices", id));
  for (const Eigen::Vector3d& p : ring) {
    require(p.allFinite(), at("vertex is not finite", id));
    require(std::abs(plane.signedDistance(p)) <= 1e-6 * (1.0 + p.norm()), at("vertex is off the plane", id));
  }
}

void checkPolygons(const Segmentation& result) {
  std::vector<bool> has_polygon(result.regions.size() + 1, false);
  std::int32_t previous = 0;
  for (const PlanarPolygon& polygon : result.polygons) {
    require(polygon.id >= previous, "polygons are not in ascending id");
    previous = polygon.id;
    const Plane& plane = regionOf(polygon, result.regions).plane;
    has_polygon[static_cast<std::size_t>(polygon.id)] = true;
    checkRing(polygon.outer, plane, polygon.id);
    for (const auto& hole : polygon.holes) checkRing(hole, plane, polygon.id);
    require(std::isfinite(polygon.area) && polygon.area > 0.0, at("area is not positive", polygon.id));
  }
  const auto with = std::count(has_polygon.begin(), has_polygon.end(), true);
  require(static_cast<int>(result.regions.size()) - with == result.regions_without_polygon,
          "a region has neither a polygon nor is it counted as one without");
  const PolygonQuality quality = polygonQuality(result.regions, result.polygons);
  require(quality.invalid == 0, "polygon is not valid: " + quality.first_fault);
}

bool same(const std::vector<PlanarPolygon>& a, const std::vector<PlanarPolygon>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PlanarPolygon& p, const PlanarPolygon& q) {
    return p.id == q.id && p.outer == q.outer && p.holes == q.holes && p.area == q.area;
  });
}

}  // namespace

void checkGrid(const BeamGrid& grid) {
  const auto n = static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.cols);
  require(grid.rows > 0 && grid.cols > 0 && grid.range.size() == n && grid.dir_x.size() == n, "grid's sizes disagree");
  for (int i = 0; i < grid.size(); ++i) {
    const Eigen::Vector3f d = grid.direction(i);
    require(d.allFinite() && std::abs(d.norm() - 1.0F) < 1e-3F, "direction is not a finite unit vector");
    require(grid.origin(i).allFinite(), "origin is not finite");
    const float range = grid.range[static_cast<std::size_t>(i)];
    require(std::isnan(range) || (range > 0.0F && std::isfinite(range)), "range is neither positive nor NaN");
  }
}

void checkSegmentation(const BeamGrid& grid, const Segmentation& result, const Config& config) {
  require(result.labels.rows == grid.rows && result.labels.cols == grid.cols &&
              result.labels.labels.size() == static_cast<std::size_t>(grid.size()),
          "label image has not the size of the grid");
  std::vector<int> points(result.regions.size() + 1, 0);
  int valid = 0;
  for (int i = 0; i < grid.size(); ++i) {
    const std::int32_t label = result.labels.labels[static_cast<std::size_t>(i)];
    require(label >= 0 && static_cast<std::size_t>(label) < points.size(),
            "label " + std::to_string(label) + " has no region");
    require(label == 0 || grid.valid(i), "pixel without a measurement has a label");
    ++points[static_cast<std::size_t>(label)];
    valid += grid.valid(i) ? 1 : 0;
  }
  require(valid == result.valid_points, "valid points are counted wrong");
  for (std::size_t i = 0; i < result.regions.size(); ++i) {
    const PlanarRegion& region = result.regions[i];
    require(region.id == static_cast<std::int32_t>(i) + 1, "ids are not 1..N");
    require(region.points == points[i + 1], at("points are counted wrong", region.id));
    require(region.points >= smallestRegion(config, grid.size(), 0.0), at("smaller than min_size", region.id));
    require(i == 0 || region.points <= result.regions[i - 1].points, "ids are not in descending size");
    checkRegion(region);
  }
  checkPolygons(result);
}

void segmentAndCheck(const BeamGrid& grid, const Config& config) {
  checkGrid(grid);
  const Segmentation result = segment(grid, config);
  checkSegmentation(grid, result, config);
  if (grid.size() <= kRepeated) {
    const Segmentation again = segment(grid, config);
    require(result.labels.labels == again.labels.labels && same(result.polygons, again.polygons), "two runs differ");
  }

  const std_msgs::Header header;
  const PlanarPolygonArray array = toPolygonArray(result, header);
  require(array.polygons.size() == result.polygons.size(), "message lost a polygon");
  for (const PlanarPolygonMsg& polygon : array.polygons) {
    for (const auto& p : polygon.outer.points)
      require(std::isfinite(p.x + p.y + p.z), "message has a vertex that is not finite");
  }
  const SegmentationStatistics statistics = toStatistics(result, header);
  require(statistics.planar_points <= statistics.valid_points, "more planar points than points");
  require(toLabelImage(result.labels, header).data.size() == 4 * grid.range.size(), "label image message has another size");
  const auto cloud = toSegmentedCloud(grid, result.labels, header);
  require(cloud.data.size() == std::size_t{cloud.row_step} * cloud.height, "segmented cloud has another size");
  for (const PlanarPolygon& polygon : result.polygons) {
    require(triangulate(polygon, regionOf(polygon, result.regions).plane.normal).size() % 3 == 0,
            at("broken triangle", polygon.id));
  }
}

}  // namespace ppc::fuzz
