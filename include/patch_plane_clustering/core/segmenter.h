// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/segmentation.h"

namespace ppc {

/// @brief Patch-based Plane Clustering: labels of the planar regions of a grid of beams (PPC's own stages, up to the label
/// image). Deterministic: same grid and config, same labels.
/// @param stages if given, the time of each stage is appended.
LabelImage clusterPatches(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages = nullptr);

/// @brief The whole pipeline: labels, region statistics, polygons.
Segmentation segment(const BeamGrid& grid, const Config& config);

/// @brief The steps that every method shares once it has labels: small regions dropped, ids by size, planes, polygons.
Segmentation finishSegmentation(const BeamGrid& grid, LabelImage labels, const Config& config,
                                std::vector<StageTime> stages);

}  // namespace ppc
