// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/range_image.h"

#include <vector>

namespace ppc::bench {

/// Points of the standard image: 300 lines of a UTM-30LX.
constexpr int kStandardPoints = 300 * 1081;

/// @brief The simulated office as a nodding UTM-30LX sees it, with the errors of its data sheet. For other numbers of points
/// than the standard image has, lines and beams grow alike, over the same field of view. Simulated once a size, then kept.
const RangeImage& officeImage(int points = kStandardPoints);

/// @brief An organised cloud as other sensors deliver it; NaN where there is no measurement.
struct Cloud {
  int rows = 0, cols = 0;
  std::vector<float> x, y, z;  ///< [m]
};
Cloud cloudOf(const BeamGrid& grid);

}  // namespace ppc::bench
