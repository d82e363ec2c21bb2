// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/ros/messages.h"

namespace ppc {

/// @brief Whether two range images are the same measurement: stamp, frame, and all that a segmentation may depend on. The
/// accounts of their lines and their sequence numbers may differ. Ranges bit for bit, so that invalid ones equal themselves.
bool isSameImage(const RangeImageMsg& a, const RangeImageMsg& b);

}  // namespace ppc
