// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <stdexcept>
#include <string>

namespace ppc::fuzz {

/// @brief A promise that was not kept: what a fuzzer reports as a crash.
class BrokenPromise : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void require(bool kept, const std::string& promise) {
  if (!kept) throw BrokenPromise(promise);
}

/// @brief Every beam has a finite unit direction and a finite origin; ranges are positive or NaN.
void checkGrid(const BeamGrid& grid);

/// @brief All that is promised about a segmentation: ids, counts, planes, polygons.
void checkSegmentation(const BeamGrid& grid, const Segmentation& result, const Config& config);

/// @brief Segments the grid and checks the grid, the result, a second run (same result) and every message made from it.
void segmentAndCheck(const BeamGrid& grid, const Config& config);

}  // namespace ppc::fuzz
