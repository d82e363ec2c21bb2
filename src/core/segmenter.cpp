// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmenter.h"

#include "patch_plane_clustering/core/region_statistics.h"

#include <chrono>

namespace patch_plane_clustering {
namespace {

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

Segmentation segment(const BeamGrid& grid, const Config& config) {
  std::vector<StageTime> stages;
  LabelImage labels = clusterPatches(grid, config, &stages);
  return finishSegmentation(grid, std::move(labels), config, std::move(stages));
}

Segmentation finishSegmentation(const BeamGrid& grid, LabelImage labels, const Config& config,
                                std::vector<StageTime> stages) {
  Stopwatch watch;
  Segmentation result;
  result.stages = std::move(stages);
  renumberBySize(grid, config.min_size, labels);
  result.regions = describeRegions(grid, labels);
  result.stages.emplace_back("statistics", watch.lap());
  result.polygons = extractPolygons(grid, labels, result.regions, config.polygons);
  result.stages.emplace_back("polygons", watch.lap());
  for (int i = 0; i < grid.size(); ++i) result.valid_points += grid.valid(i) ? 1 : 0;
  for (const PlanarRegion& region : result.regions) {
    bool found = false;
    for (const PlanarPolygon& polygon : result.polygons) found = found || polygon.id == region.id;
    result.regions_without_polygon += found ? 0 : 1;
  }
  result.labels = std::move(labels);
  return result;
}

}  // namespace patch_plane_clustering
