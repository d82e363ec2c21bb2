// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/small_regions.h"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Working memory of refitSmallPlanes(), which one image after the other may use.
struct SmallPlaneMemory {
  SmallRegions small;
  std::vector<std::vector<RegionPoint>> points;  ///< of one region, a list a thread
  std::vector<int> of_whole;                     ///< points of each label
  std::vector<char> strays;                      ///< of each region, whether there are any
};

/// @brief Fits the planes of small regions to the points that these have, see fitNear(), and takes strays off them.
///
/// Planes come from the merge of clusters, and borders are drawn afterwards: a face four pixels wide of which one column
/// went to its neighbour, or came from it, was a few degrees off, and so were the extension of the region and the crease
/// beside it, both of which follow the plane. A piece that has less than half of a label's points keeps the plane of all, as
/// it does if less than half of its own are near one. Strays are points of a region that are ten standard deviations off its
/// plane, of noise and of all that planes are allowed (ToleratedScale): some that a label without any region has won are
/// given back unseen. If there are more than one in twenty they stay: it may be the plane that is wrong. Deterministic,
/// whatever the number of threads; thread-safe with memory of one's own.
/// @param runs of the pieces. @param whole the label that each piece is part of. @param planes a (see moments.h) of every
/// piece; those of pieces of JudgedImage::smallest to SmallRegions::kMostPoints pixels may be set anew.
/// @param labels pieces; strays become 0.
/// @return whether there were any, so that the runs are no longer those of the labels.
bool refitSmallPlanes(const JudgedImage& image, const std::vector<LabelRun>& runs, const std::vector<std::int32_t>& whole,
                      SmallPlaneMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels, int threads = 1);

}  // namespace ppc
