// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <vector>

namespace patch_plane_clustering {

/// @brief Moments of the pixels of every label, about the centre of `cells`, weighed with the noise; index = label.
std::vector<Moments> labelMoments(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                                  const LabelImage& labels);

/// @brief Merges labels that touch and lie on one plane, most similar first.
///
/// Two conditions must hold. The joint plane serves both as wholes: with a wider tolerance than from patch to patch, for walls
/// bow. And where they meet there is no step: the strips on both sides of the border are compared by their offset alone (a
/// plane tilted across a step hides three quarters of it).
/// @param cells blocks of pixels by which "touching" and "where they meet" are measured.
void mergeLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                 double threshold, LabelImage& labels);

}  // namespace patch_plane_clustering
