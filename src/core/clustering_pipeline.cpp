// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/clustering_pipeline.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/range_limit.h"
#include "patch_plane_clustering/core/run_listing.h"

#include <algorithm>
#include <vector>

namespace ppc {
namespace {

constexpr int kFewestPoints = 20;  // of a cluster of small patches: much of a thin region may lie around it
constexpr int kGapCols = 2;        // pixels that a piece may leap

PatchComparison comparisonOf(const Config& config) { return {config.running_plane, config.noise_aware}; }

// Rows that span the angle of a column in the middle of an image.
double rowsPerColumn(const PatchGrid& patches) {
  return static_cast<double>(patches.strip_rows[patches.strips() / 2]) / patches.strip_cols;
}

// The same angle across the lines of the middle of an image, where they lie apart.
int gapRows(const PatchGrid& patches) { return kGapCols * std::max(1, static_cast<int>(rowsPerColumn(patches))); }

}  // namespace

ClusteringPipeline::ClusteringPipeline(const BeamGrid& grid, double line_error_left, const Config& config, StageTimer& timer,
                                       ClusteringMemory& memory, LabelImage& labels)
    : grid_(grid),
      config_(config),
      timer_(timer),
      memory_(memory),
      labels_(labels),
      settle_(config.refine && config.settle_borders),
      errors_(patchesWithErrors(line_error_left)),
      smallest_(smallestRegion(config, grid.size(), errors_.typical)) {
  memory.typical_noise = errors_.typical;
}

ImageErrors ClusteringPipeline::patchesWithErrors(double line_error_left) {
  AngularSteps& steps = memory_.steps;
  if (config_.equal_angle) {
    measureSteps(grid_, memory_.patch_grids, steps, config_.threads);
  } else {
    steps = AngularSteps();
  }
  makePatchGrid(grid_, std::min(config_.patch_size, std::max(grid_.rows, grid_.cols)), steps, nullptr, config_.threads,
                memory_.patch_grids, memory_.patches);
  timer_.lap("moments");
  const ImageErrors errors = estimateErrors(grid_, line_error_left, config_, memory_);
  timer_.lap("fits");
  return errors;
}

void ClusteringPipeline::run() {
  growAndMerge();
  bool runs_known = false;
  if (config_.refine) {
    refine(1);
    timer_.lap("refinement");
    if (config_.second_pass) {
      runs_known = secondPass();
      timer_.lap("second pass");
    } else {
      updateChangedShares();
      labelPlanes(memory_.shares, memory_.planes);
    }
  }
  takePieces(runs_known);
  finishRegions();
}

void ClusteringPipeline::growAndMerge() {
  const PatchGrid& patches = memory_.patches;
  CellShares& shares = memory_.shares;
  growClusters(patches, errors_.noise, errors_.tolerance, config_.similarity_threshold, comparisonOf(config_),
               memory_.growth, memory_.clusters, config_.threads);
  shareClusters(memory_.clusters, shares);
  timer_.lap("clustering");
  if (config_.merge) {
    mergeShares(patches, errors_.noise, errors_.tolerance, config_.similarity_threshold, memory_.merging, shares,
                memory_.planes, config_.threads);
    timer_.lap("merging");
  } else {
    labelPlanes(shares, memory_.planes);
  }
  patchLabels(grid_, patches, shares, memory_.patch_rows, labels_, config_.threads);
}

void ClusteringPipeline::refine(std::int32_t first_open) {
  refineLabels(grid_, memory_.patches, memory_.shares, memory_.planes, errors_.noise, errors_.tolerance, first_open,
               memory_.refinement, labels_, memory_.changed, config_.threads);
}

void ClusteringPipeline::updateChangedShares() {
  updateShares(grid_, memory_.patches, errors_.noise, labels_, memory_.changed, memory_.shares, memory_.share_updates,
               config_.threads);
}

bool ClusteringPipeline::split(bool merged) {
  return splitLabels(grid_, memory_.patches, errors_.noise, errors_.tolerance, smallest_, merged, memory_.splits,
                     memory_.shares, labels_, config_.threads);
}

// Regions too thin for any patch to fit inside: smaller patches of what the first pass left over, with labels from `first`
// on. Cells where there are any are marked as changed.
void ClusteringPipeline::addSmallRegions(std::int32_t first) {
  PatchGrid& patches = memory_.small_patches;
  makePatchGrid(grid_, std::max(2, (config_.patch_size + 2) / 2), memory_.steps, &labels_, config_.threads,
                memory_.patch_grids, patches);
  weighAndGatePatches(errors_.noise, errors_.tolerance, patches, config_.threads);
  markTruncated(grid_, errors_.range_limit, errors_.noise, patches);
  const PatchClusters& clusters = memory_.clusters;
  growClusters(patches, errors_.noise, errors_.tolerance, config_.similarity_threshold, comparisonOf(config_),
               memory_.growth, memory_.clusters, config_.threads);
  const int fewest_points = std::min(kFewestPoints, smallest_ / 4);
  std::int32_t next = first;
  for (const Cluster& cluster : clusters.clusters) {
    if (cluster.moments.n < fewest_points) continue;
    for (int m = cluster.begin; m < cluster.end; ++m) {
      const Patch& patch = patches.patches[clusters.members[m]];
      for (int r = patch.row_begin; r < patch.row_end; ++r) {
        for (int c = patch.col_begin; c < patch.col_end; ++c) {
          const int i = grid_.index(r, c);
          if (!grid_.valid(i) || labels_.labels[i] != 0) continue;
          labels_.labels[i] = next;
          memory_.changed[memory_.patches.patchAt(r, c)] = 1;
        }
      }
    }
    ++next;
  }
}

// Returns whether the runs of the labels are known.
bool ClusteringPipeline::secondPass() {
  CellShares& shares = memory_.shares;
  const auto first_new = static_cast<std::int32_t>(memory_.planes.size());
  addSmallRegions(first_new);
  updateChangedShares();
  const bool split_regions = config_.split_regions && config_.noise_aware;
  if (split_regions) split(false);
  labelPlanes(shares, memory_.planes);
  refine(first_new);
  updateChangedShares();
  if (!config_.merge) {
    labelPlanes(shares, memory_.planes);
    return false;
  }
  mergeLabels(memory_.patches, errors_.noise, errors_.tolerance, config_.similarity_threshold, memory_.merging, shares,
              labels_, memory_.pieces.runs, memory_.planes, config_.threads);
  // Merging tolerates more than splitting does; in white noise, what it has joined is known well enough to be judged, and in
  // smooth noise what it has joined beyond doubt. A side that is too small for a region leaves a better one behind.
  if (!split_regions || !split(true)) return true;
  labelPlanes(shares, memory_.planes);
  return false;
}

void ClusteringPipeline::takePieces(bool runs_known) {
  LabelPieces& pieces = memory_.pieces;
  BorderMemory& borders = memory_.borders;
  const int gap_rows = gapRows(memory_.patches);
  if (!runs_known) listRuns(labels_, borders.listing, pieces.runs, config_.threads);
  Beside split_runs(config_.threads, [&] {  // needs runs alone, no image
    splitRuns(grid_.cols, gap_rows, kGapCols, memory_.split, pieces.runs, pieces.whole);
    prepareCurvature(grid_, pieces.runs, memory_.curvature);
  });
  if (settle_) {
    contestLabels(grid_, memory_.patches, memory_.shares, memory_.planes, errors_.noise, errors_.tolerance, borders.contest,
                  labels_, config_.threads);
    timer_.lap("contest");
  }
  split_runs.wait();
  timer_.lap("components");
  Beside list(config_.threads, [&] {
    if (settle_) listRuns(labels_, borders.contested);
  });
  planarNames(grid_, errors_.noise, errors_.tolerance, config_.max_turn, memory_.curvature, pieces.names, config_.threads);
  timer_.lap("curvature");
  list.wait();
  if (!settle_) {
    paintRuns(pieces.runs, pieces.names, labels_);
    listRuns(labels_, borders.listing, borders.settled, config_.threads);
    return;
  }
  if (config_.merge && config_.noise_aware) {
    reuniteLabels(grid_.rows, grid_.cols, memory_.shares, errors_.noise, errors_.tolerance, memory_.merging.meetings.groups,
                  static_cast<std::int32_t>(memory_.merging.names.size()), memory_.reunion, pieces, borders.contested,
                  memory_.planes);
  }
  settleContested(grid_.cols, pieces, memory_.planes.size(), smallest_, gap_rows, kGapCols, borders, labels_,
                  memory_.settled, config_.threads);
  timer_.lap("borders");
}

// Draws borders along the planes of whole regions, and joins regions that touch then and have one plane. `runs` are those
// of the labels until creases are aligned.
void ClusteringPipeline::drawBorders(const JudgedImage& image, std::vector<LabelRun>& runs,
                                     std::vector<Eigen::Vector3d>& planes) {
  CreaseMeetings& meetings = memory_.meetings;
  const auto find_meetings = [&] {
    findCreaseMeetings(runs, labels_.rows, labels_.cols, planes.size(), smallest_, meetings);
  };
  const auto find_again = [&] {
    listRuns(labels_, memory_.borders.listing, runs, config_.threads);
    find_meetings();
  };
  find_meetings();
  if (config_.settle_low_steps && config_.noise_aware) {
    if (settleLowSteps(image, meetings, runs, rowsPerColumn(memory_.patches), memory_.low_steps, planes, labels_))
      find_again();
    timer_.lap("low steps");
    if (config_.merge && reuniteRegions(image, meetings, runs, memory_.region_reunion, planes, labels_)) find_again();
    timer_.lap("reunion");
  }
  if (config_.align_creases) {
    alignCreases(image, planes, meetings, memory_.creases, labels_, config_.threads);
    timer_.lap("creases");
  }
}

void ClusteringPipeline::finishRegions() {
  const JudgedImage image{grid_, memory_.patches.center, errors_.noise, errors_.tolerance, smallest_};
  std::vector<LabelRun>& runs = memory_.borders.settled;  // of the labels, until creases are aligned
  const auto list_again = [&] { listRuns(labels_, memory_.borders.listing, runs, config_.threads); };
  const std::vector<std::int32_t>& whole = settle_ ? memory_.settled : memory_.pieces.whole;
  std::vector<Eigen::Vector3d>& planes = memory_.piece_planes;
  planes.clear();
  for (const std::int32_t label : whole) planes.push_back(memory_.planes[label]);
  if (config_.refit_regions && config_.noise_aware) {
    if (refitSmallPlanes(image, runs, whole, memory_.small_planes, planes, labels_, config_.threads)) list_again();
    timer_.lap("small planes");
  }
  if (config_.dissolve_regions && config_.noise_aware) {
    dissolveRegions(image, planes, memory_.dissolution, labels_, runs, config_.threads);
    timer_.lap("dissolution");
  }
  bool changed = false;
  if (config_.extend_regions && config_.noise_aware) {
    changed = extendRegions(image, planes, memory_.extension, labels_, runs, config_.threads);
    timer_.lap("extension");
  }
  if (config_.fill_holes) {
    changed = fillHoles(image, planes, memory_.holes, labels_, runs) || changed;
    timer_.lap("holes");
  }
  if (changed) list_again();
  if (config_.refine && (config_.settle_low_steps || config_.align_creases)) drawBorders(image, runs, planes);
  if (config_.trim_regions && config_.noise_aware) {
    trimRegions(image, memory_.trimming, labels_, config_.threads);
    timer_.lap("trimming");
  }
}

}  // namespace ppc
