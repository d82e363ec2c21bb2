// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/error_model.h"

#include <cmath>

namespace patch_plane_clustering::sim {

ErrorModel ErrorModel::dataSheet(double noise_scale) {
  ErrorModel e;
  e.noise_scale = noise_scale;
  e.mixed_pixels = 0.5;
  e.dropouts = 0.002;
  e.range_grid = 0.001;
  e.encoder_noise = 1e-4;
  return e;
}

ErrorModel ErrorModel::realistic(double noise_scale) {
  ErrorModel e = dataSheet(noise_scale);
  e.correlated_noise = true;
  e.range_grid = 0.01;
  e.incidence_bias = 0.01;
  e.wall_bow = 0.005;
  e.lever_arm_error = 0.005;
  e.tilt_offset = 0.2 * M_PI / 180.0;
  e.tilt_backlash = 0.1 * M_PI / 180.0;
  return e;
}

}  // namespace patch_plane_clustering::sim
