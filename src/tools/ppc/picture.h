// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <opencv2/core/mat.hpp>

namespace ppc {

/// @brief A picture to look at: the range image (near is warm, far is blue, black = no measurement) and, beside or below it,
/// the labels, a colour a region, with the outlines of the polygons as the sensor sees them. Left and right are as the
/// sensor sees them, and small images are enlarged.
cv::Mat drawSegmentation(const BeamGrid& grid, const Segmentation& result);

}  // namespace ppc
