// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/error_model.h"

#include <cmath>
#include <stdexcept>

namespace ppc::sim {
namespace {

void requireRange(const std::string& name, double value, double max) {
  if (!(value >= 0.0 && value <= max)) {
    throw std::invalid_argument(name + " is " + std::to_string(value) + ", allowed: 0 to " + std::to_string(max));
  }
}

}  // namespace

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

const std::vector<ErrorField>& errorFields() {
  static const std::vector<ErrorField> fields{{"noise_scale", 1000.0, &ErrorModel::noise_scale},
                                              {"mixed_pixels", 1.0, &ErrorModel::mixed_pixels},
                                              {"dropouts", 1.0, &ErrorModel::dropouts},
                                              {"range_grid", 1.0, &ErrorModel::range_grid},
                                              {"incidence_bias", 0.1, &ErrorModel::incidence_bias},
                                              {"wall_bow", 0.1, &ErrorModel::wall_bow},
                                              {"lever_arm_error", 0.1, &ErrorModel::lever_arm_error},
                                              {"tilt_offset", 0.1, &ErrorModel::tilt_offset},
                                              {"tilt_backlash", 0.1, &ErrorModel::tilt_backlash},
                                              {"encoder_noise", 0.1, &ErrorModel::encoder_noise},
                                              {"tilt_grid", 0.1, &ErrorModel::tilt_grid},
                                              {"line_error", 0.1, &ErrorModel::line_error}};
  return fields;
}

void setErrorField(ErrorModel& errors, const std::string& name, double value) {
  std::string known = "correlated_noise, motion_in_line";
  for (const ErrorField& field : errorFields()) {
    if (field.name == name) {
      requireRange(name, value, field.max);
      errors.*field.value = value;
      return;
    }
    known += ", " + field.name;
  }
  if (name != "correlated_noise" && name != "motion_in_line") {
    throw std::invalid_argument("error source is '" + name + "', allowed: " + known);
  }
  requireRange(name, value, 1.0);
  (name == "correlated_noise" ? errors.correlated_noise : errors.motion_in_line) = value != 0.0;
}

void checkErrors(const ErrorModel& errors) {
  for (const ErrorField& field : errorFields()) requireRange(field.name, errors.*field.value, field.max);
}

}  // namespace ppc::sim
