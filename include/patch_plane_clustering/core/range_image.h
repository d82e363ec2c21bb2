// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace ppc {

/// @brief Organised range image of a moving line scanner.
///
/// Row r is one scan line, column c one bearing: the indices of an element imply its direction. The range is *radial*
/// (along the beam, not along z as in a depth image). Validity follows REP 117: -Inf too close, +Inf no return, NaN bad.
///
/// The laser moves within a line. Its pose is therefore given at `poses_per_row` beams of each row, evenly spaced from the
/// first to the last beam of the row, and is interpolated between them: linearly for the origin and for the scan plane's
/// axes. A point is  p = origin(r, c) + range * (x_axis(r, c) cos(bearing(c)) + y_axis(r, c) sin(bearing(c))).
struct RangeImage {
  int rows = 0;                               ///< number of scan lines, in ascending tilt
  int cols = 0;                               ///< beams per line
  double bearing_min = 0.0;                   ///< bearing of column 0 in the scan plane [rad]
  double bearing_increment = 0.0;             ///< bearing step from one column to the next [rad], may be negative
  double range_min = 0.0;                     ///< smallest valid range [m]
  double range_max = 0.0;                     ///< largest valid range [m]
  std::vector<float> ranges;                  ///< rows x cols, row-major [m]
  std::vector<float> intensities;             ///< same layout as ranges, or empty [device units]
  int poses_per_row = 1;                      ///< poses of the laser along each row, at least 1
  std::vector<Eigen::Isometry3d> line_poses;  ///< rows x poses_per_row: laser scan frame in the frame of the image
  std::vector<double> tilts;                  ///< rows: tilt angle at the middle of the row [rad], ascending
  std::vector<double> row_stamps;             ///< rows: time of the first beam [s]

  /// Bearing of a column; fractional columns are allowed [rad].
  double bearing(double col) const { return bearing_min + col * bearing_increment; }
};

/// @brief True if `range` is a measurement by REP 117: finite and within [range_min, range_max]. NaN is not.
inline bool isValidRange(float range, double range_min, double range_max) {
  return range_min <= range && range <= range_max;
}

/// @brief Throws std::invalid_argument naming the first inconsistent field (sizes, non-finite geometry, poses).
void checkConsistent(const RangeImage& image);

}  // namespace ppc
