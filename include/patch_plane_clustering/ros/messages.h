// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The generated messages live in the package's namespace and two of them are named as core types are. Here, and only here,
// their C++ names get a suffix; their ROS names stay what they are. Include this instead of the generated headers.
#define RangeImage RangeImageMsg
#define PlanarPolygon PlanarPolygonMsg
#include <patch_plane_clustering/PlanarPolygon.h>
#include <patch_plane_clustering/PlanarPolygonArray.h>
#include <patch_plane_clustering/RangeImage.h>
#include <patch_plane_clustering/SegmentationStatistics.h>
#undef RangeImage
#undef PlanarPolygon
