// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

#include <string>
#include <vector>

namespace ppc {

/// @brief Where and when an image was taken, as it is written beside its polygons.
struct ImageSource {
  std::string frame_id;
  double stamp = 0.0;  ///< [s]; 0 for files that have none
};

/// @brief Labels as a 16-bit picture of the image's size, 0 = no plane. @throws std::runtime_error beyond 65535 regions.
cv::Mat labelPicture(const LabelImage& labels);

/// @brief Reads a label picture of one channel, 8 or 16 bits. @throws std::runtime_error naming the file and the cause.
LabelImage readLabels(const std::string& path);

/// @brief Planes and polygons: {"frame_id", "stamp", "rows", "cols", "planes": [{"id", "normal", "d",
/// "covariance", "rms", "points", "area", "outer", "holes"}]}, one entry a polygon, normal . p = d; the covariance is that
/// of (normal, d), row by row.
nlohmann::ordered_json polygonsJson(const BeamGrid& grid, const Segmentation& result, const ImageSource& source);

/// @brief Counts and times of one segmentation; the names of stages and their milliseconds under "stages_ms".
nlohmann::ordered_json statisticsJson(const BeamGrid& grid, const Segmentation& result);

/// @brief The polygons as coloured triangles, ascii PLY.
std::string meshPly(const Segmentation& result);

}  // namespace ppc
