// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief The pixels of one piece, cut out of the image: 1 inside, 0 outside. Pixel (0, 0) is (row, col) of the image.
struct PieceMask {
  int row = 0;
  int col = 0;
  LabelImage labels;
};

/// @brief Rings of one component: the outer one first, then its holes.
struct PixelPiece {
  const PixelRing *first = nullptr, *last = nullptr;

  const PixelRing* begin() const { return first; }
  const PixelRing* end() const { return last; }
  const PixelRing& outer() const { return *first; }
};

struct PixelPieces {
  std::vector<PixelRing> rings;  ///< piece by piece
  std::vector<PixelPiece> pieces;
  std::vector<std::size_t> next;  ///< scratch: for every component, where its next ring goes
};

/// @brief Working memory of splitAtFolds().
struct FoldMemory {
  std::vector<int> above, below;  ///< signs of corners of blocks
  std::vector<char> busy;         ///< blocks with pixels of the mask
  std::vector<std::int32_t> split;
};

/// @brief Rings grouped by component, each with holes of at least `min_hole_size` pixels. @param out overwritten.
void ringsByComponent(const PixelContours& contours, int min_hole_size, PixelPieces& out);

/// @brief Pixels inside the outer ring and outside the other rings. @param mask overwritten.
void maskPiece(const std::vector<PixelCorner>& corners, const PixelPiece& rings, PieceMask& mask);

/// @brief Labels the pixels 1 or 2 by the handedness of the image on the plane, which flips at the pole of a nodding scan;
/// pixels whose own footprint folds become 0. @return false if there is no fold; the mask is unchanged then.
bool splitAtFolds(const CornerProjection& projection, PieceMask& mask, FoldMemory& memory);

/// @brief Labels the two halves, across the longer side, 1 and 2. @return false for a single pixel.
bool splitInHalf(PieceMask& mask);

}  // namespace ppc
