// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

/// @brief The pixels of one piece, cut out of the image: 1 inside, 0 outside. Pixel (0, 0) is (row, col) of the image.
struct PieceMask {
  int row = 0;
  int col = 0;
  LabelImage labels;
};

/// @brief Rings grouped by component: outer ring first, then its holes of at least `min_hole_size` pixels.
std::vector<std::vector<PixelRing>> ringsByComponent(const PixelContours& contours, int min_hole_size);

/// @brief Pixels inside the outer ring (the first) and outside the other rings.
PieceMask maskOfPiece(const std::vector<PixelCorner>& corners, const std::vector<PixelRing>& rings);

/// @brief Labels the pixels 1 or 2 by the handedness of the image on the plane, which flips at the pole of a nodding scan;
/// pixels whose own footprint folds become 0. @return false if there is no fold; the mask is unchanged then.
bool splitAtFolds(const CornerProjection& projection, PieceMask& mask);

/// @brief Labels the two halves, across the longer side, 1 and 2. @return false for a single pixel.
bool splitInHalf(PieceMask& mask);

}  // namespace ppc
