// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"

#include <vector>

namespace ppc {

/// @brief What the fit of a plane to all points of a region starts from.
struct BeamStart {
  bool along = false;                                ///< false: the beams do not tell the plane, as they see it edge-on
  BeamFrame frame;                                   ///< the plane
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of a beam of the region
  ErrorScale scale;                                  ///< of the errors; limit: those above it do not count; kNoLimit: all do
};

/// @brief Working memory of startOf(), which one region after the other may use.
struct BeamStartMemory {
  std::vector<PixelStretch> sample;
  std::vector<float> values;  ///< to be sorted
};

/// @brief Fits a plane to some hundred points of a region, or all if it has no more: to inverse ranges first, in which
/// it is linear, however thin the region and however slanted; then along the beams; then for errors that go across the
/// beams as well, 2.5 mm, beside the noise along them that the region shows; then without points farther off than 2.5
/// standard deviations, which are told from the median of the errors. Real scans need those across: a thin region seen at a
/// grazing angle would turn towards the sensor, as regression does whose regressors have errors.
/// @param begin,end blocks of the region, in the order of the pixels.
BeamStart startOf(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, BeamStartMemory& memory);

}  // namespace ppc
