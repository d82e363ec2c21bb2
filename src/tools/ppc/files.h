// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <string>

namespace patch_plane_clustering {

/// @brief Throws std::runtime_error "FILE: cause" unless `path` is a readable, regular, non-empty file.
void requireReadableFile(const std::string& path);

/// @brief Writes text, whole or not at all. An empty path writes nothing. @throws std::runtime_error naming the file.
void writeText(const std::string& path, const std::string& text);

/// @brief The same for a picture; the extension chooses the format. An empty path writes nothing.
void writeImage(const std::string& path, const cv::Mat& image);

}  // namespace patch_plane_clustering
