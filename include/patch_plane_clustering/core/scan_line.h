// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace ppc {

/// @brief One line of a 2D laser: n beams, evenly spaced in bearing and in time.
struct ScanLine {
  double stamp = 0.0;              ///< time of the first beam [s]
  double time_increment = 0.0;     ///< time from one beam to the next [s], 0 = all at once
  double bearing_min = 0.0;        ///< bearing of the first beam in the scan plane [rad]
  double bearing_increment = 0.0;  ///< from one beam to the next [rad], may be negative
  double range_min = 0.0;          ///< smallest valid range [m]
  double range_max = 0.0;          ///< largest valid range [m]
  std::vector<float> ranges;       ///< n [m]; any value is allowed, validity by REP 117
  std::vector<float> intensities;  ///< n [device units], or empty

  /// Time of beam `index` (fractional allowed) [s].
  double beamStamp(double index) const { return stamp + index * time_increment; }
  /// Time of the last beam [s]. Precondition: not empty.
  double lastStamp() const { return beamStamp(static_cast<double>(ranges.size() - 1)); }
};

/// @brief What makes the line unusable ("time_increment is negative (-0.1)"), or empty if nothing does.
std::string faultOf(const ScanLine& line);

/// @brief True if lines can share an image: same number of beams, bearings and range limits.
bool sameLayout(const ScanLine& a, const ScanLine& b);

}  // namespace ppc
