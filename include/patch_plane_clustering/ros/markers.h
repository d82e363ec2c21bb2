// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

namespace ppc {

/// @brief Polygons for rviz, visible from both sides: namespaces `faces` (filled, with the holes left open), `outlines` and
/// `ids` (a text at each region's centroid). Colours as regionColor(). The first marker deletes those of the image before;
/// every marker has the header of the image.
visualization_msgs::MarkerArray toMarkers(const Segmentation& segmentation, const std_msgs::Header& header);

}  // namespace ppc
