// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/patch_grid.h"

namespace ppc {

/// @brief Lists the neighbours of all patches, which have been laid out and summed. The same whatever the threads.
void linkPatches(int threads, PatchGridMemory& memory, PatchGrid& grid);

}  // namespace ppc
