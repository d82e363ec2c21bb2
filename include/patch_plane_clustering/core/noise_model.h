// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/sensor_model.h"

#include <vector>

namespace patch_plane_clustering {

/// @brief Range noise as a function of range: from the sensor model, or estimated from an image.
class NoiseModel {
 public:
  /// Noise of a data sheet times a factor.
  NoiseModel(const SensorModel& sensor, double scale);

  /// @brief Estimates the noise from the residuals of small patches: most of them lie on surfaces that are flat over their
  /// width, and a low quantile leaves the others out. Seen over several lines at once, the residuals contain noise that is
  /// correlated along a line, and errors that a whole line shares; differences along the line would be blind to both.
  static NoiseModel estimate(const PatchGrid& patches, const SensorModel& sensor);

  /// One standard deviation [m] at a range [m].
  double sigma(double range) const;

 private:
  static int bin(double range);
  std::vector<double> sigma_;  // by range bin
};

}  // namespace patch_plane_clustering
