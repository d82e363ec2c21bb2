// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/similarity.h"

#include <limits>
#include <optional>

namespace ppc {

/// @brief How the ranges of an image err, and what planes are allowed beyond that.
struct ImageErrors {
  NoiseModel noise;
  CoplanarityTolerance tolerance;
  std::optional<double> range_limit;  ///< where the sensor's range ends, see findRangeLimit() [m]
  /// Noise at the ranges of planar patches, their mean [m]; infinite if noise is not to be heeded.
  double typical = std::numeric_limits<double>::infinity();
};

/// @brief Takes them from an image's patches, so far as the configuration wants them estimated. Weighs and gates the patches
/// by them, and marks those at the limit of the range.
/// @param line_error_left standard deviation of what lines are still off [m]. @param memory with the patches of the image;
/// the result refers to it, and stands until the next image.
ImageErrors estimateErrors(const BeamGrid& grid, double line_error_left, const Config& config, ClusteringMemory& memory);

}  // namespace ppc
