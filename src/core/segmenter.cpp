// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmenter.h"

#include "patch_plane_clustering/core/clustering_pipeline.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/stage_timer.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr int kFewestThinned = 40;  // points of a region of a thinned image: of fewer, many fit a plane by chance

}  // namespace

LabelImage clusterPatches(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) {
  ClusteringMemory memory;
  LabelImage labels;
  clusterPatches(grid, config, memory, labels, stages);
  return labels;
}

void clusterPatches(const BeamGrid& measured, const Config& config, ClusteringMemory& memory, LabelImage& labels,
                    std::vector<StageTime>* stages) {
  const WorkerPool::Alert alert(WorkerPool::ofProcess(), config.threads);
  StageTimer timer(stages);
  const bool cleared = config.clear_strays && config.noise_aware && clearStrays(measured, memory.strays, config.threads);
  const BeamGrid& points = cleared ? memory.strays.grid : measured;
  const LineErrors line_errors =
      config.noise_aware ? estimateLineErrors(points, memory.lines, config.threads) : LineErrors();
  if (!line_errors.empty()) removeLineErrors(line_errors, points, memory.corrected);
  const BeamGrid& lines = line_errors.empty() ? points : memory.corrected;
  const bool stood =
      config.thin_standing_lines && config.noise_aware && !lines.beams_exact && thinStandingLines(lines, memory.standing);
  const BeamGrid& moving = stood ? memory.standing.grid : lines;
  LabelImage& moving_labels = stood ? memory.standing.labels : labels;
  const double tolerance = std::hypot(config.sigma_distance, line_errors.range_left);
  if (config.thin_smooth_noise && config.noise_aware && thinSmoothNoise(moving, tolerance, memory.smooth)) {
    SmoothNoiseMemory& smooth = memory.smooth;
    Config thinned = config;
    if (config.min_size > 0) {
      thinned.min_size = std::max(kFewestThinned, config.min_size / (smooth.stride * smooth.stride));
    }
    ClusteringPipeline(smooth.grid, line_errors.range_left, thinned, timer, memory, smooth.labels).run();
    labelThinned(moving, memory.patches.center, smooth, moving_labels, config.threads);
    timer.lap("thinning");
  } else {
    ClusteringPipeline(moving, line_errors.range_left, config, timer, memory, moving_labels).run();
  }
  if (stood) {
    labelStandingLines(lines, memory.standing, labels);
    timer.lap("standing lines");
  }
}

Segmentation segment(const BeamGrid& grid, const Config& config) {
  ClusteringMemory memory;
  Segmentation result;
  segment(grid, config, memory, result);
  return result;
}

void segment(const BeamGrid& grid, const Config& config, ClusteringMemory& memory, Segmentation& result) {
  result.stages.clear();
  clusterPatches(grid, config, memory, result.labels, &result.stages);
  finishSegmentation(grid, smallestRegion(config, grid.size(), memory.typical_noise), config, memory.finishing, result);
}

void finishSegmentation(const BeamGrid& grid, int smallest, const Config& config, FinishingMemory& memory,
                        Segmentation& result) {
  const WorkerPool::Alert alert(WorkerPool::ofProcess(), config.threads);
  LabelImage& labels = result.labels;
  StageTimer timer(&result.stages);
  std::vector<LabelRun>& runs = memory.runs;
  renumberBySize(grid, smallest, memory.renumbering, labels, runs, result.valid_points, config.threads);
  Beside outlines(config.threads, [&] { traceOutlines(labels, runs, config.polygons, memory.polygons); });
  describeRegions(grid, runs, memory.regions, result.regions, config.threads);
  timer.lap("statistics");
  outlines.wait();
  makePolygons(grid, labels, result.regions, config.polygons, memory.polygons, result.polygons, config.threads);
  timer.lap("polygons");
  result.regions_without_polygon = 0;
  for (const PlanarRegion& region : result.regions) {
    bool found = false;
    for (const PlanarPolygon& polygon : result.polygons) found = found || polygon.id == region.id;
    result.regions_without_polygon += found ? 0 : 1;
  }
}

}  // namespace ppc
