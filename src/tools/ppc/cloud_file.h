// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <string>

namespace ppc {

/// @brief Reads an organised PCD (ascii, binary or compressed; height > 1; metres; sensor at the origin; a point with a
/// non-finite coordinate, or at the origin, is no measurement).
/// @param note if given: becomes one line for the user if the file says something that is left out, its VIEWPOINT
/// @throws std::runtime_error naming the file and the cause: missing, not a regular file, empty, truncated, no PCD,
/// unorganised, without x, y, z.
BeamGrid readCloud(const std::string& path, std::string* note = nullptr);

}  // namespace ppc
