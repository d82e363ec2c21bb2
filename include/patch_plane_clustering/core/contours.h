// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief One corner of a pixel outline: the upper left corner of pixel (row, col); 0 <= row <= rows, 0 <= col <= cols.
///
/// Where two pixels of one label touch only diagonally, the outline passes the same corner twice. Each of the two visits
/// then says in which direction its own pixel lies (pull = -1 or +1, otherwise 0), so that the two can be told apart.
struct PixelCorner {
  std::int32_t row = 0;
  std::int32_t col = 0;
  std::int8_t pull_row = 0;
  std::int8_t pull_col = 0;
};

/// @brief One closed ring of corners; not repeated at the end. Consecutive corners are one pixel side apart.
struct PixelRing {
  std::int32_t label = 0;
  int component = 0;  ///< rings of one 4-connected component share it; numbered from 0 in raster order
  bool hole = false;
  int pixels = 0;                  ///< enclosed pixels, of whatever label
  std::size_t begin = 0, end = 0;  ///< its corners in PixelContours::corners
};

/// @brief All outlines of a label image.
struct PixelContours {
  std::vector<PixelCorner> corners;
  std::vector<PixelRing> rings;  ///< outer ring of a component before its holes
  int components = 0;
};

/// @brief Working memory of traceContours(), which one image after the other may use.
struct ContourMemory {
  std::vector<LabelRun> runs;
  std::vector<int> left;         ///< component whose outline runs along the left side of a pixel
  std::vector<char> right_seen;  ///< whether an outline along the right side of a pixel has been followed
};

/// @brief Follows the pixel sides between labels ("crack following") for all labels above 0 in one pass.
///
/// Regions are 4-connected and their holes 8-connected: rings therefore touch neither themselves nor each other, except at
/// corners with a pull. The labelled pixels lie on the right of the direction of travel: clockwise for outer rings when rows
/// run downwards, counter-clockwise for holes. Time: O(pixels + corners).
/// @param runs of the labels. @param out overwritten; its memory is used again.
void traceContours(const LabelImage& labels, const std::vector<LabelRun>& runs, ContourMemory& memory, PixelContours& out);

/// @brief The same where the runs are not known.
void traceContours(const LabelImage& labels, ContourMemory& memory, PixelContours& out);
PixelContours traceContours(const LabelImage& labels);

}  // namespace ppc
