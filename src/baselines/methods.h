// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/baselines/plane_segmenter.h"

#include <memory>

namespace ppc {

/// @brief Point-based region growing after J. Poppinga, N. Vaskevicius, A. Birk, K. Pathak, Fast plane detection and
/// polygonalization in noisy 3D range images, IROS 2008: a region starts from a small flat neighbourhood and takes the next
/// best neighbouring point as long as the point lies near the plane and the mean square error stays small; the plane is
/// updated incrementally. Differences: seeds are tried flattest first, not at random, and thresholds follow the noise.
std::unique_ptr<PlaneSegmenter> makeRegionGrowing();

/// @brief PCL's RegionGrowing (smoothness of normals, then curvature) on normals of windows of the grid.
std::unique_ptr<PlaneSegmenter> makePclRegionGrowing();

/// @brief PCL's OrganizedMultiPlaneSegmentation with refinement, on normals of windows of the grid.
std::unique_ptr<PlaneSegmenter> makePclMultiPlane();

/// @brief PCL's RANSAC plane fit, again and again on the points that are left; each plane is split into the parts that are
/// connected in the image.
std::unique_ptr<PlaneSegmenter> makeRansac();

}  // namespace ppc
