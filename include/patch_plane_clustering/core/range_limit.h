// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"

#include <optional>

namespace ppc {

/// @brief Looks for the limit at which a sensor's range ends in an image.
///
/// Of a surface that goes on beyond the limit, those points are measured there whose errors bring them nearer, the fewer the
/// farther away they are. So what is farthest in the image has holes, and stands off its plane towards the sensor: along a
/// wall, a strip of some standard deviations of noise that fits no plane of what is beside it.
/// @return the mean range of the farthest patch, if among the pixels of the patches within one and a half standard
/// deviations of it one in ten or more, and of 400 or more, has no measurement; none else. Deterministic; thread-safe.
std::optional<double> findRangeLimit(const PatchGrid& patches, const NoiseModel& noise);

/// @brief Marks the patches about the limit: those not more than six standard deviations of noise before it, of whose pixels
/// one in twenty or more has no measurement, are PatchGrid::truncated, and not planar.
/// @param limit [m]; none: no patch is.
void markTruncated(const BeamGrid& grid, const std::optional<double>& limit, const NoiseModel& noise, PatchGrid& patches);

}  // namespace ppc
