// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"

#include <vector>

namespace ppc {

/// @brief Working memory of adaptToSurfaces(), which one image after the other may use.
struct SurfaceNoiseMemory {
  struct Work {
    std::vector<int> around;      ///< a patch and those within two steps of it
    std::vector<float> variance;  ///< of those that are like it
  };
  std::vector<Work> workers;         ///< one a thread
  std::vector<float> variance;       ///< of each patch's residuals, over that of the noise; 0 where it is not known
  std::vector<float> factor, grown;  ///< of each patch, before and after a step into the patches beside
  std::vector<char> reached;         ///< patches that a piece has been counted for
  std::vector<int> piece;            ///< patches that differ and hang together
  std::vector<float> pixels;         ///< factor of each pixel
};

/// @brief Finds surfaces whose ranges have more noise than is typical at that range, as dark ones do for most lasers, and
/// weighs the patches there accordingly.
///
/// The residuals of one patch do not tell noise from an edge or a bend. Those of a surface do: patch after patch they are of
/// about the same size, whereas edges leave residuals of all sizes; and they change from line to line and along the lines as
/// those of typical surfaces do, whereas those of a bend are smooth both ways, and those of stairs along them. Where most
/// patches around one are like it, the median of these is the noise there, if enough such patches hang together. It goes on
/// into patches beside that the typical noise does not explain: part of the surface may be in them.
/// @param patches weighed by `noise`; those on such surfaces are weighed anew, their gates are left to the caller.
/// @param noise given the factors of pixels, if any differ, which are kept in `memory` (NoiseModel::setFactors()).
/// @return whether any surface differs.
bool adaptToSurfaces(const BeamGrid& grid, PatchGrid& patches, NoiseModel& noise, SurfaceNoiseMemory& memory,
                     int threads = 1);

}  // namespace ppc
