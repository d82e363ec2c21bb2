// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <memory>
#include <string>
#include <vector>

namespace ppc {

/// @brief A method that labels the planar regions of a grid of beams. PPC and the methods it is compared with share it.
class PlaneSegmenter {
 public:
  virtual ~PlaneSegmenter() = default;

  /// Labels 1..N in any order, 0 = none. Stage times are appended if asked for. Not thread-safe on one object.
  virtual LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) = 0;
};

/// @brief Names of all methods: ppc, region_growing, pcl_region_growing, pcl_multi_plane, ransac.
const std::vector<std::string>& segmenterNames();

/// @brief Makes a method by name. @throws std::invalid_argument listing the known names.
std::unique_ptr<PlaneSegmenter> makeSegmenter(const std::string& name);

/// @brief Labels by `method`, then region statistics and polygons (finishSegmentation).
Segmentation segmentWith(PlaneSegmenter& method, const BeamGrid& grid, const Config& config);

}  // namespace ppc
