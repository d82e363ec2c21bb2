// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/kept_list.h"
#include "patch_plane_clustering/core/piece_split.h"
#include "patch_plane_clustering/core/polygon_piece.h"
#include "patch_plane_clustering/core/ring_loops.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Working memory of one thread that makes polygons of regions.
struct OutlineMemory {
  Outlines outlines;
  PieceMemory piece;
  LoopMemory loops;
  PieceMask mask;
  FoldMemory folds;
  ContourMemory contours;
  struct Parts {
    PixelContours contours;
    PixelPieces pieces;
  };
  std::vector<Parts> parts;        ///< of a piece that was cut, of one of those that was cut again, and so on
  KeptList<PolygonPiece> pieces;   ///< of a region
  std::vector<std::size_t> order;  ///< of those, by size
};

/// @brief Working memory of extractPolygons(), which one image after the other may use.
struct PolygonMemory {
  ContourMemory tracing;
  PixelContours contours;
  PixelPieces pieces;
  std::vector<OutlineMemory> of_thread;
  std::vector<KeptList<PlanarPolygon>> of_region;
};

}  // namespace ppc
