// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

namespace ppc::sim {

/// @brief What a real scanner does wrong. Every source is switched on its own; 0 or false is off.
struct ErrorModel {
  double noise_scale = 0.0;       ///< factor on the sensor's range noise
  bool correlated_noise = false;  ///< the noise is correlated along the line (see kNoiseFilter), as measured on a URG-04LX
  double mixed_pixels = 0.0;      ///< probability that a beam whose spot lies across a depth edge reads something between
  double dropouts = 0.0;          ///< probability that a beam reads nothing
  double range_grid = 0.0;        ///< ranges are rounded to multiples of this [m]
  double incidence_bias = 0.0;    ///< range read too long by this times (1 - cos(incidence)) [m]
  double wall_bow = 0.0;          ///< large faces bulge by this [m]
  double lever_arm_error = 0.0;   ///< the laser sits this far from where it is said to sit [m]
  double tilt_offset = 0.0;       ///< reported tilt minus true tilt [rad]
  double tilt_backlash = 0.0;     ///< reported tilt leads by half of this when it grows, lags when it falls [rad]
  double encoder_noise = 0.0;     ///< standard deviation of each joint sample [rad]
  double tilt_grid = 0.0;         ///< reported tilts are rounded to multiples of this: groups of lines at one angle [rad]
  double line_error = 0.0;        ///< standard deviation of a range error that all beams of a line share [m]
  bool motion_in_line = true;     ///< the laser moves while a line is taken; false: all beams of a line are taken at once

  /// Nothing wrong, motion apart.
  static ErrorModel none() { return {}; }

  /// White noise of the data sheet times `noise_scale`, 1 mm grid, mixed pixels, a few dropouts, a little encoder noise.
  static ErrorModel dataSheet(double noise_scale);

  /// As dataSheet(), with what makes real recordings harder: correlated noise, 1 cm grid, 10 mm bias with incidence, walls
  /// bowed by 5 mm, lever arm off by 5 mm, tilt off by 0.2 deg, backlash of 0.1 deg.
  static ErrorModel realistic(double noise_scale);
};

/// @brief One quantity of an ErrorModel: its public name and allowed range (from 0).
struct ErrorField {
  std::string name;
  double max;
  double ErrorModel::*value;
};

/// @brief Every quantity, in the order of the struct; switches apart. Thread-safe.
const std::vector<ErrorField>& errorFields();

/// @brief Sets a quantity or, by 0 and 1, a switch. @throws std::invalid_argument naming the field, its value and what is
/// allowed.
void setErrorField(ErrorModel& errors, const std::string& name, double value);

/// @brief Throws std::invalid_argument naming the first quantity out of range.
void checkErrors(const ErrorModel& errors);

/// @brief Moving average whose output has unit variance and autocorrelation 0.7, 0.5, 0.3, 0.1 at lags 1 to 4.
/// From the spectral factorisation of these values.
constexpr std::array<double, 5> kNoiseFilter{0.6940409473739492, 0.46546904779610515, 0.410177209176417, 0.3356192310498757,
                                             0.1440837177955727};

}  // namespace ppc::sim
