// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/sensor_model.h"

#include <string>
#include <vector>

namespace ppc::sim {

/// @brief A 2D laser as its data sheet describes it.
struct Sensor {
  std::string name;
  int beams = 0;
  double bearing_min = 0.0;        ///< [rad]
  double bearing_increment = 0.0;  ///< [rad]
  double line_rate = 0.0;          ///< lines a second [Hz]
  double range_min = 0.0;          ///< [m]
  double range_max = 0.0;          ///< [m]
  double spot_angle = 0.0;         ///< full divergence of the beam [rad]
  SensorModel noise;

  /// Time between beams: the mirror turns once a line [s].
  double timeIncrement() const;
};

/// @brief utm_30lx, urg_04lx, lms_200.
const std::vector<std::string>& sensorNames();

/// @brief @throws std::invalid_argument listing the known names.
Sensor makeSensor(const std::string& name);

}  // namespace ppc::sim
