// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

struct ClusteringMemory;  // see segmentation_memory.h
struct FinishingMemory;

/// @brief Patch-based Plane Clustering: labels of the planar regions of a grid of beams (PPC's own stages, up to the label
/// image). Deterministic: same grid and config, same labels.
/// @param stages if given, the time of each stage is appended.
LabelImage clusterPatches(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages = nullptr);
/// @brief The same with memory. @param labels overwritten; its memory is used again, too.
void clusterPatches(const BeamGrid& measured, const Config& config, ClusteringMemory& memory, LabelImage& labels,
                    std::vector<StageTime>* stages);

/// @brief The whole pipeline: labels, region statistics, polygons.
Segmentation segment(const BeamGrid& grid, const Config& config);
/// @brief The same with memory. @param result overwritten; its memory is used again, too.
void segment(const BeamGrid& grid, const Config& config, ClusteringMemory& memory, Segmentation& result);

/// @brief The steps that every method shares once it has labels: small regions dropped, ids by size, planes, polygons.
/// @param smallest points that a region has at least. @param result with the labels and the stages up to them; the rest is
/// overwritten, and its memory used again.
void finishSegmentation(const BeamGrid& grid, int smallest, const Config& config, FinishingMemory& memory,
                        Segmentation& result);

}  // namespace ppc
