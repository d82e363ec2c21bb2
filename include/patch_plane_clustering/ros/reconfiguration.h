// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/PatchPlaneClusteringConfig.h"
#include "patch_plane_clustering/core/config.h"

namespace ppc {

using patch_plane_clustering::PatchPlaneClusteringConfig;

/// @brief The configuration in the form of dynamic_reconfigure (config/PatchPlaneClustering.cfg).
PatchPlaneClusteringConfig toReconfigurable(const Config& config);

/// @brief `base` with all fields of an update. @throws std::invalid_argument naming the field, its value and the allowed
/// range.
Config fromReconfigurable(const PatchPlaneClusteringConfig& update, const Config& base);

}  // namespace ppc
