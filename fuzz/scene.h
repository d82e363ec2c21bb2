// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "input.h"
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/range_image.h"

namespace ppc::fuzz {

/// @brief A configuration with every field in its allowed range.
Config takeConfig(Input& input);

/// @brief The geometry of a small scan, consistent but perhaps odd: through the pole, with a lever arm, all round; no
/// ranges.
RangeImage takeScan(Input& input);

/// @brief Ranges of a few planes with borders, holes, noise and corrupt pixels along the beams of `grid`; what is not hit is
/// NaN, +Inf or a constant.
std::vector<float> takeRanges(Input& input, const BeamGrid& grid);

}  // namespace ppc::fuzz
