// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/small_regions.h"

#include <vector>

namespace ppc {

/// @brief Working memory of refitSmallPlanes(), which one image after the other may use.
struct SmallPlaneMemory {
  SmallRegions small;
  std::vector<std::vector<RegionPoint>> points;  ///< of one region, a list a thread
  std::vector<int> strays;                       ///< of each region
};

/// @brief Fits the planes of small regions to the points that these have, see fitNear(), and takes strays off them.
///
/// Planes come from the merge of clusters, and borders are drawn afterwards: a face four pixels wide of which one column
/// went to its neighbour, or came from it, was a few degrees off, and so were the extension of the region and the crease
/// beside it, both of which follow the plane. Strays are points of a region, given back to it by a label that is none, that
/// are ten standard deviations of noise and tolerance and more off its plane. Deterministic, whatever the number of threads;
/// thread-safe with memory of one's own.
/// @param runs of the labels. @param planes a (see moments.h, about `center`) of every label; those of regions of `smallest`
/// to SmallRegions::kMostPoints pixels are set anew, if they have a plane. @param labels strays become 0.
/// @return whether there were any, so that the runs are no longer those of the labels.
bool refitSmallPlanes(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance, int smallest, const std::vector<LabelRun>& runs,
                      SmallPlaneMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels, int threads = 1);

}  // namespace ppc
