// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/scan_line.h"

#include <cmath>
#include <sstream>

namespace ppc {
namespace {

constexpr std::size_t kMostBeams = 100000;  // no 2D laser comes near; keeps a corrupt header from eating the memory
constexpr double kLongestLine = 10.0;       // [s]
constexpr double kWidestLine = 6.3;         // a turn and a little for rounding [rad]

template <typename T>
std::string because(const char* what, T value) {
  std::ostringstream text;
  text << what << " (" << value << ")";
  return text.str();
}

}  // namespace

std::string faultOf(const ScanLine& line) {
  if (line.ranges.empty()) return "ranges are empty";
  if (line.ranges.size() > kMostBeams) return because("too many beams", line.ranges.size());
  if (!line.intensities.empty() && line.intensities.size() != line.ranges.size()) {
    return because("as many intensities as ranges expected, or none", line.intensities.size());
  }
  const auto steps = static_cast<double>(line.ranges.size() - 1);
  if (!std::isfinite(line.stamp) || line.stamp <= 0.0) return because("stamp is not set", line.stamp);
  if (!std::isfinite(line.time_increment)) return because("time_increment is not finite", line.time_increment);
  if (line.time_increment < 0.0) return because("time_increment is negative", line.time_increment);
  if (steps * line.time_increment > kLongestLine) return because("line lasts too long [s]", steps * line.time_increment);
  if (!std::isfinite(line.bearing_min)) return because("angle_min is not finite", line.bearing_min);
  if (!std::isfinite(line.bearing_increment)) return because("angle_increment is not finite", line.bearing_increment);
  if (line.bearing_increment == 0.0 && steps > 0.0) return "angle_increment is zero";
  if (steps * std::abs(line.bearing_increment) > kWidestLine) {
    return because("line is wider than a turn [rad]", steps * std::abs(line.bearing_increment));
  }
  if (!(line.range_min >= 0.0)) return because("range_min is negative or NaN", line.range_min);
  if (!(line.range_min < line.range_max)) return because("range_max does not exceed range_min, or is NaN", line.range_max);
  return {};
}

bool sameLayout(const ScanLine& a, const ScanLine& b) {
  return a.ranges.size() == b.ranges.size() && a.bearing_min == b.bearing_min &&
         a.bearing_increment == b.bearing_increment && a.range_min == b.range_min && a.range_max == b.range_max;
}

}  // namespace ppc
