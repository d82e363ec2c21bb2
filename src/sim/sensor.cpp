// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/sensor.h"

#include <cmath>
#include <stdexcept>

namespace ppc::sim {
namespace {

constexpr double kDegree = M_PI / 180.0;

Sensor utm30lx() {
  Sensor s;
  s.name = "utm_30lx";
  s.beams = 1081;
  s.bearing_min = -135.0 * kDegree;
  s.bearing_increment = 0.25 * kDegree;
  s.line_rate = 40.0;
  s.range_min = 0.1;
  s.range_max = 30.0;
  s.spot_angle = 0.005;
  s.noise = {0.01, 0.03, 10.0, 0.0};
  return s;
}

// The steps are 360 deg / 1024; 4.095 m is the guaranteed range, the device reports up to 5.6 m.
Sensor urg04lx() {
  Sensor s;
  s.name = "urg_04lx";
  s.beams = 682;
  s.bearing_increment = 360.0 / 1024.0 * kDegree;
  s.bearing_min = -0.5 * (s.beams - 1) * s.bearing_increment;
  s.line_rate = 10.0;
  s.range_min = 0.02;
  s.range_max = 5.6;
  s.spot_angle = 0.008;
  s.noise = {0.01, 0.01, 10.0, 0.01};
  return s;
}

// At its resolution of 0.5 deg, in the mode that counts centimetres.
Sensor lms200() {
  Sensor s;
  s.name = "lms_200";
  s.beams = 361;
  s.bearing_increment = 0.5 * kDegree;
  s.bearing_min = -90.0 * kDegree;
  s.line_rate = 37.5;
  s.range_min = 0.1;
  s.range_max = 81.0;
  s.spot_angle = 0.005;
  s.noise = {0.005, 0.01, 8.0, 0.0};
  return s;
}

const std::vector<Sensor>& sensors() {
  static const std::vector<Sensor> all{utm30lx(), urg04lx(), lms200()};
  return all;
}

}  // namespace

double Sensor::timeIncrement() const { return bearing_increment / (2.0 * M_PI * line_rate); }

const std::vector<std::string>& sensorNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Sensor& sensor : sensors()) all.push_back(sensor.name);
    return all;
  }();
  return names;
}

Sensor makeSensor(const std::string& name) {
  std::string allowed;
  for (const Sensor& sensor : sensors()) {
    if (sensor.name == name) return sensor;
    allowed += (allowed.empty() ? "" : ", ") + sensor.name;
  }
  throw std::invalid_argument("sensor is '" + name + "', allowed: " + allowed);
}

}  // namespace ppc::sim
