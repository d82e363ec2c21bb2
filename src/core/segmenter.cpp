// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmenter.h"

#include "patch_plane_clustering/core/border_settlement.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/core/crease_alignment.h"
#include "patch_plane_clustering/core/curvature.h"
#include "patch_plane_clustering/core/hole_filling.h"
#include "patch_plane_clustering/core/label_reunion.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/line_errors.h"
#include "patch_plane_clustering/core/noise_correlation.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/patch_labels.h"
#include "patch_plane_clustering/core/range_limit.h"
#include "patch_plane_clustering/core/refinement.h"
#include "patch_plane_clustering/core/region_dissolution.h"
#include "patch_plane_clustering/core/region_extension.h"
#include "patch_plane_clustering/core/region_merging.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/stage_timer.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ppc {
namespace {

constexpr int kFewestPoints = 20;  // of a cluster of small patches: much of a thin region may lie around it

PatchComparison comparisonOf(const Config& config) { return {config.running_plane, config.noise_aware}; }

// What correlated errors do to the noise, if it is estimated, and to the tolerance. Returns whether anything.
bool estimateCorrelation(const Config& config, NoiseModel& noise, CoplanarityTolerance& tolerance,
                         ClusteringMemory& memory) {
  PatchGrid& patches = memory.patches;
  forEachPart(config.threads, kSampleParts, [&](int part) {
    sampleInflation(patches, part, memory.inflation);
    sampleCorrelation(patches, part, memory.correlation);
  });
  tolerance.inflation = inflationOf(memory.inflation);
  const NoiseCorrelation found = correlationOf(memory.correlation, tolerance.inflation);
  tolerance.inflation_growth = found.growth;
  tolerance.patch_points = found.points;
  if (config.noise_scale > 0.0 || found.variance == 1.0) return tolerance.inflation != 1.0 || found.growth > 0.0;
  noise.scale(std::sqrt(found.variance));
  tolerance.inflation = std::max(1.0, tolerance.inflation / found.variance);
  for (Patch& patch : patches.patches) patch.weigh(found.variance);
  return true;
}

// Regions too thin for any patch to fit inside: smaller patches of what the first pass left over, with labels from `first`
// on. Cells where there are any are marked as changed.
void addSmallRegions(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                     const Config& config, const std::optional<double>& range_limit, std::int32_t first,
                     ClusteringMemory& memory, LabelImage& labels) {
  PatchGrid& patches = memory.small_patches;
  makePatchGrid(grid, std::max(2, (config.patch_size + 2) / 2), memory.steps, &labels, config.threads, memory.patch_grids,
                patches);
  weighAndGatePatches(noise, tolerance, patches, config.threads);
  markTruncated(grid, range_limit, noise, patches);
  const PatchClusters& clusters = memory.clusters;
  growClusters(patches, noise, tolerance, config.similarity_threshold, comparisonOf(config), memory.growth, memory.clusters,
               config.threads);
  const int fewest_points = std::min(kFewestPoints, smallestRegion(config, grid.size()) / 4);
  std::int32_t next = first;
  for (const Cluster& cluster : clusters.clusters) {
    if (cluster.moments.n < fewest_points) continue;
    for (int m = cluster.begin; m < cluster.end; ++m) {
      const Patch& patch = patches.patches[clusters.members[m]];
      for (int r = patch.row_begin; r < patch.row_end; ++r) {
        for (int c = patch.col_begin; c < patch.col_end; ++c) {
          const int i = grid.index(r, c);
          if (!grid.valid(i) || labels.labels[i] != 0) continue;
          labels.labels[i] = next;
          memory.changed[memory.patches.patchAt(r, c)] = 1;
        }
      }
    }
    ++next;
  }
}

// Everything once the lines are where they were and no two of them are the same. @param line_error_left standard deviation
// of what they are still off [m].
void clusterLines(const BeamGrid& grid, double line_error_left, const Config& config, StageTimer& timer,
                  ClusteringMemory& memory, LabelImage& labels) {
  PatchGrid& patches = memory.patches;
  AngularSteps& steps = memory.steps;
  if (config.equal_angle) {
    measureSteps(grid, memory.patch_grids, steps, config.threads);
  } else {
    steps = AngularSteps();
  }
  makePatchGrid(grid, std::min(config.patch_size, std::max(grid.rows, grid.cols)), steps, nullptr, config.threads,
                memory.patch_grids, patches);
  timer.lap("moments");

  NoiseModel noise = config.noise_scale > 0.0 ? NoiseModel(config.sensor, config.noise_scale)
                                              : NoiseModel::estimate(patches, config.sensor, memory.noise, config.threads);
  CoplanarityTolerance tolerance{std::hypot(config.sigma_distance, line_error_left), config.sigma_angle, 1.0};
  tolerance.least_distance = line_error_left;
  weighAndGatePatches(noise, tolerance, patches, config.threads);
  if (config.noise_by_surface && config.noise_aware && config.noise_scale == 0.0 &&
      adaptToSurfaces(grid, patches, noise, memory.surface_noise, config.threads)) {
    gatePatches(noise, tolerance, patches, config.threads);
  }
  if (config.noise_aware && estimateCorrelation(config, noise, tolerance, memory)) {
    gatePatches(noise, tolerance, patches, config.threads);
  }
  std::optional<double> range_limit;
  if (config.avoid_range_limit && config.noise_aware) range_limit = findRangeLimit(patches, noise);
  markTruncated(grid, range_limit, noise, patches);
  timer.lap("fits");

  growClusters(patches, noise, tolerance, config.similarity_threshold, comparisonOf(config), memory.growth, memory.clusters,
               config.threads);
  CellShares& shares = memory.shares;
  shareClusters(memory.clusters, shares);
  timer.lap("clustering");
  std::vector<Eigen::Vector3d>& planes = memory.planes;  // of the labels
  if (config.merge) {
    mergeShares(patches, noise, tolerance, config.similarity_threshold, memory.merging, shares, planes, config.threads);
    timer.lap("merging");
  } else {
    labelPlanes(shares, planes);
  }
  patchLabels(grid, patches, shares, memory.patch_rows, labels, config.threads);
  std::vector<char>& changed = memory.changed;
  const auto update = [&] {
    updateShares(grid, patches, noise, labels, changed, shares, memory.share_updates, config.threads);
  };
  const int smallest = smallestRegion(config, grid.size());
  const auto split_labels = [&] {
    return splitLabels(grid, patches, noise, tolerance, smallest, memory.splits, shares, labels, config.threads);
  };
  const auto refine = [&](std::int32_t first_open) {
    refineLabels(grid, patches, shares, planes, noise, tolerance, first_open, memory.refinement, labels, changed,
                 config.threads);
  };
  LabelPieces& pieces = memory.pieces;
  bool runs_known = false;
  if (config.refine) {
    refine(1);
    timer.lap("refinement");
    if (config.second_pass) {
      const auto first_new = static_cast<std::int32_t>(planes.size());
      addSmallRegions(grid, noise, tolerance, config, range_limit, first_new, memory, labels);
      update();
      const bool split_regions = config.split_regions && config.noise_aware;
      if (split_regions) split_labels();
      labelPlanes(shares, planes);
      refine(first_new);
      update();
      if (config.merge) {
        mergeLabels(patches, noise, tolerance, config.similarity_threshold, memory.merging, shares, labels, pieces.runs,
                    planes, config.threads);
      } else {
        labelPlanes(shares, planes);
      }
      runs_known = config.merge;
      // Merging tolerates more than splitting does; in white noise, what it has joined is known well enough to be judged. A
      // side that is too small for a region leaves a better one behind.
      if (split_regions && config.merge && tolerance.isWhite() && split_labels()) {
        labelPlanes(shares, planes);
        runs_known = false;
      }
      timer.lap("second pass");
    } else {
      update();
      labelPlanes(shares, planes);
    }
  }
  const int gap_rows = 2 * std::max(1, patches.strip_rows[patches.strips() / 2] / patches.strip_cols), gap_cols = 2;
  BorderMemory& borders = memory.borders;
  if (!runs_known) listRuns(labels, borders.listing, pieces.runs, config.threads);
  const bool settle = config.refine && config.settle_borders;
  Beside split(config.threads, [&] {  // needs runs alone, no image
    splitRuns(grid.cols, gap_rows, gap_cols, memory.split, pieces.runs, pieces.whole);
    prepareCurvature(grid, pieces.runs, memory.curvature);
  });
  if (settle) {
    contestLabels(grid, patches, shares, planes, noise, tolerance, borders.contest, labels, config.threads);
    timer.lap("contest");
  }
  split.wait();
  timer.lap("components");
  Beside list(config.threads, [&] {
    if (settle) listRuns(labels, borders.contested);
  });
  planarNames(grid, noise, tolerance, config.max_turn, memory.curvature, pieces.names, config.threads);
  timer.lap("curvature");
  list.wait();
  if (settle) {
    if (config.merge && config.noise_aware) {
      reuniteLabels(grid.rows, grid.cols, shares, noise, tolerance, memory.merging.meetings.groups,
                    static_cast<std::int32_t>(memory.merging.names.size()), memory.reunion, pieces, borders.contested,
                    planes);
    }
    settleContested(grid.cols, pieces, planes.size(), smallest, gap_rows, gap_cols, borders, labels, memory.settled,
                    config.threads);
    timer.lap("borders");
  } else {
    paintRuns(pieces.runs, pieces.names, labels);
    listRuns(labels, borders.listing, borders.settled, config.threads);
  }
  std::vector<LabelRun>& runs = borders.settled;  // of the labels, until creases are aligned
  std::vector<Eigen::Vector3d>& piece_planes = memory.piece_planes;
  piece_planes.clear();
  const std::vector<std::int32_t>& whole = settle ? memory.settled : pieces.whole;
  for (const std::int32_t label : whole) piece_planes.push_back(planes[label]);
  if (config.refit_regions && config.noise_aware) {
    if (refitSmallPlanes(grid, patches.center, noise, tolerance, smallest, runs, whole, memory.small_planes, piece_planes,
                         labels, config.threads)) {
      listRuns(labels, borders.listing, runs, config.threads);
    }
    timer.lap("small planes");
  }
  if (config.dissolve_regions && config.noise_aware) {
    dissolveRegions(grid, piece_planes, patches.center, noise, tolerance, smallest, memory.dissolution, labels, runs,
                    config.threads);
    timer.lap("dissolution");
  }
  bool extended = false;
  if (config.extend_regions && config.noise_aware) {
    extended = extendRegions(grid, piece_planes, patches.center, noise, tolerance, smallest, memory.extension, labels, runs,
                             config.threads);
    timer.lap("extension");
  }
  if (config.fill_holes) {
    const bool filled =
        fillHoles(grid, piece_planes, patches.center, noise, tolerance, smallest, memory.holes, labels, runs);
    extended = extended || filled;
    timer.lap("holes");
  }
  if (extended) listRuns(labels, borders.listing, runs, config.threads);
  if (config.refine && config.align_creases) {
    alignCreases(grid, piece_planes, patches.center, noise, tolerance, smallest, memory.creases, runs, labels,
                 config.threads);
    timer.lap("creases");
  }
  if (config.trim_regions && config.noise_aware) {
    trimRegions(grid, patches.center, noise, tolerance, smallest, memory.trimming, labels, config.threads);
    timer.lap("trimming");
  }
}

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
  if (!config.thin_standing_lines || !config.noise_aware || lines.beams_exact ||
      !thinStandingLines(lines, memory.standing)) {
    clusterLines(lines, line_errors.range_left, config, timer, memory, labels);
    return;
  }
  clusterLines(memory.standing.grid, line_errors.range_left, config, timer, memory, memory.standing.labels);
  labelStandingLines(lines, memory.standing, labels);
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
  finishSegmentation(grid, config, memory.finishing, result);
}

void finishSegmentation(const BeamGrid& grid, const Config& config, FinishingMemory& memory, Segmentation& result) {
  const WorkerPool::Alert alert(WorkerPool::ofProcess(), config.threads);
  LabelImage& labels = result.labels;
  StageTimer timer(&result.stages);
  std::vector<LabelRun>& runs = memory.runs;
  renumberBySize(grid, smallestRegion(config, grid.size()), memory.renumbering, labels, runs, result.valid_points,
                 config.threads);
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
