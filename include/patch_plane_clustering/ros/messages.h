// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <patch_plane_clustering/LineAccounts.h>
#include <patch_plane_clustering/PlanarPolygon.h>
#include <patch_plane_clustering/PlanarPolygonArray.h>
#include <patch_plane_clustering/RangeImage.h>
#include <patch_plane_clustering/SegmentationStatistics.h>

namespace ppc {

// Generated messages live in namespace patch_plane_clustering; some of them are named as core types are.
using LineAccountsMsg = patch_plane_clustering::LineAccounts;
using RangeImageMsg = patch_plane_clustering::RangeImage;
using RangeImageMsgPtr = patch_plane_clustering::RangeImagePtr;
using RangeImageMsgConstPtr = patch_plane_clustering::RangeImageConstPtr;
using PlanarPolygonMsg = patch_plane_clustering::PlanarPolygon;
using patch_plane_clustering::PlanarPolygonArray;
using patch_plane_clustering::PlanarPolygonArrayConstPtr;
using patch_plane_clustering::PlanarPolygonArrayPtr;
using patch_plane_clustering::SegmentationStatistics;
using patch_plane_clustering::SegmentationStatisticsConstPtr;
using patch_plane_clustering::SegmentationStatisticsPtr;

}  // namespace ppc
