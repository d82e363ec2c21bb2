// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/image_errors.h"
#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/stage_timer.h"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief The stages from a grid of beams to the labels of its planar regions, in order: patches, errors, clusters,
/// refinement, second pass, pieces, and what is done to regions once their pieces are known. Expects lines without errors of
/// their own, see removeLineErrors().
///
/// Labels go through three hands. Those of clusters and of their merge are numbers of planes (`memory.planes`), shared out
/// over the cells of the patch grid (`memory.shares`). takePieces() makes one label of each connected piece, and of what is
/// curved none. The stages of finishRegions() change these labels pixel by pixel.
class ClusteringPipeline {
 public:
  /// @brief Makes the patches and estimates the errors. All arguments must outlive the object.
  /// @param line_error_left standard deviation of what lines are still off [m]. @param labels overwritten by run().
  ClusteringPipeline(const BeamGrid& grid, double line_error_left, const Config& config, StageTimer& timer,
                     ClusteringMemory& memory, LabelImage& labels);

  /// To be called once.
  void run();

 private:
  ImageErrors patchesWithErrors(double line_error_left);
  void growAndMerge();
  void refine(std::int32_t first_open);
  void updateChangedShares();
  bool split(bool merged);
  void addSmallRegions(std::int32_t first);
  bool secondPass();
  void takePieces(bool runs_known);
  void drawBorders(const JudgedImage& image, std::vector<LabelRun>& runs, std::vector<Eigen::Vector3d>& planes);
  void finishRegions();

  const BeamGrid& grid_;
  const Config& config_;
  StageTimer& timer_;
  ClusteringMemory& memory_;
  LabelImage& labels_;
  const bool settle_;  ///< whether borders are settled
  const ImageErrors errors_;
  const int smallest_;  ///< points of a region
};

}  // namespace ppc
