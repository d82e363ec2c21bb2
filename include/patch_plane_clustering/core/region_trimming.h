// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/judged_image.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/near_fit.h"
#include "patch_plane_clustering/core/region_fringe.h"
#include "patch_plane_clustering/core/run_listing.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/small_regions.h"

#include <Eigen/Core>
#include <vector>

namespace ppc {

/// @brief Working memory of trimRegions(), which one image after the other may use.
struct TrimmingMemory {
  struct Work {  ///< of one thread
    std::vector<RegionPoint> points;
    std::vector<PixelStretch> kept, next;  ///< of the region, what is left of it
    FringeMemory fringe;
  };
  RunListMemory listing;
  std::vector<LabelRun> runs;  ///< of all labels
  SmallRegions small;          ///< those that are judged
  std::vector<Work> works;
  std::vector<std::vector<PixelStretch>> left;  ///< of each region, what is left of it
  std::vector<char> trimmed;                    ///< of each region, whether that is less than all
};

/// @brief Takes off small regions what they have of others along their borders, and drops those that are no planes.
///
/// Single pixels that a region has of a thin face beside it are within the noise, and turn its plane until they fit; all of
/// them together are told from noise: chi-square, of noise and CoplanarityTolerance::sigma_distance, with errors capped at
/// four standard deviations, exceeds the number of points by more than four times what noise lets it vary, and errors of
/// neighbours agree: noise that is larger than known, on dark surfaces or far away, is not smooth. From such
/// regions, those parts of the fringe that are off (Fringe::off()) are taken, the plane is fitted again, and so on. If it is
/// still none when no part is off, or a quarter of the points is gone, the region is left as it was if all that planes are
/// allowed explains its errors, which may be bows of a wall or a sensor's own (the tolerance of angles too, across the
/// surface, as similarity() has it), and from such regions no more than three pixels are taken in depth; if not, it has no
/// label any more: a few leaves of a plant, a corner of three faces.
/// For errors that are not correlated (CoplanarityTolerance::isWhite()): others exceed chi-square on planes, too. Regions
/// of fewer measured points than JudgedImage::smallest, and of more than SmallRegions::kMostPoints, are left as they are.
/// Deterministic; thread-safe with memory of one's own.
/// @param labels of valid and invalid pixels; those that are taken off become 0.
void trimRegions(const JudgedImage& image, TrimmingMemory& memory, LabelImage& labels, int threads = 1);

}  // namespace ppc
