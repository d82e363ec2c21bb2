// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/border_settlement.h"
#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/connected_pieces.h"
#include "patch_plane_clustering/core/crease_alignment.h"
#include "patch_plane_clustering/core/crease_meetings.h"
#include "patch_plane_clustering/core/curvature.h"
#include "patch_plane_clustering/core/hole_filling.h"
#include "patch_plane_clustering/core/label_reunion.h"
#include "patch_plane_clustering/core/line_errors.h"
#include "patch_plane_clustering/core/low_steps.h"
#include "patch_plane_clustering/core/noise_correlation.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/patch_labels.h"
#include "patch_plane_clustering/core/polygon_memory.h"
#include "patch_plane_clustering/core/refinement.h"
#include "patch_plane_clustering/core/region_dissolution.h"
#include "patch_plane_clustering/core/region_extension.h"
#include "patch_plane_clustering/core/region_merging.h"
#include "patch_plane_clustering/core/region_reunion.h"
#include "patch_plane_clustering/core/region_splitting.h"
#include "patch_plane_clustering/core/region_statistics.h"
#include "patch_plane_clustering/core/region_trimming.h"
#include "patch_plane_clustering/core/small_planes.h"
#include "patch_plane_clustering/core/smooth_noise.h"
#include "patch_plane_clustering/core/standing_lines.h"
#include "patch_plane_clustering/core/strays.h"
#include "patch_plane_clustering/core/surface_noise.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of finishSegmentation(), which one image after the other may use.
struct FinishingMemory {
  std::vector<LabelRun> runs;
  RenumberingMemory renumbering;
  RegionMemory regions;
  PolygonMemory polygons;
};

/// @brief Working memory of clusterPatches() and segment(). Given to one image after the other, it spares them asking the
/// system for anything, so far as they are of one size and kind; it carries nothing else from one to the next. The noise of
/// the last image is for segment(), which drops small regions.
struct ClusteringMemory {
  StrayMemory strays;
  StandingLineMemory standing;
  SmoothNoiseMemory smooth;
  LineErrorMemory lines;
  BeamGrid corrected;  ///< the image without errors of whole lines
  NoiseMemory noise;
  SurfaceNoiseMemory surface_noise;
  CorrelationMemory correlation;
  InflationMemory inflation;
  AngularSteps steps;
  PatchGridMemory patch_grids;
  PatchGrid patches, small_patches;
  double typical_noise = 0.0;  ///< see ImageErrors [m]
  PatchClusters clusters;
  GrowthMemory growth;
  CellShares shares;
  ShareMemory share_updates;
  MergeMemory merging;
  RefinementMemory refinement;
  std::vector<PatchRow> patch_rows;
  std::vector<char> changed;
  LabelSplitMemory splits;
  LabelPieces pieces;
  SplitMemory split;
  ReunionMemory reunion;
  BorderMemory borders;
  std::vector<std::int32_t> settled;  ///< label of every piece once borders are settled
  CurvatureMemory curvature;
  std::vector<Eigen::Vector3d> planes, piece_planes;  ///< of the labels, and of their pieces
  DissolutionMemory dissolution;
  SmallPlaneMemory small_planes;
  ExtensionMemory extension;
  HoleMemory holes;
  CreaseMeetings meetings;
  LowStepMemory low_steps;
  RegionReunionMemory region_reunion;
  CreaseMemory creases;
  TrimmingMemory trimming;
  FinishingMemory finishing;
};

}  // namespace ppc
