// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/grid_lines.h"

#include <utility>
#include <vector>

namespace ppc {

/// @brief Which errors the beams of a line are taken to share.
enum class LineErrorKind { kRange, kTurn, kBoth };

/// @brief One of them.
struct LineFit {
  double value = 0.0;      ///< [m or rad]
  double deviation = 0.0;  ///< standard deviation [m or rad]
  int samples = 0;         ///< beams that tell of it
};

/// @brief What a line is off against two others, one before and one after it: its own error less the weighted ones of
/// theirs.
struct LineMisfit {
  double before = 0.5, after = 0.5;  ///< weights of the two
  LineFit range;                     ///< error of all ranges
  LineFit range_alone;               ///< the same if there were none of tilt; only where turns are looked for
  LineFit turn;                      ///< error of tilt: the line lies this much nearer to the next than is said
  double between = 0.0;              ///< what it is said to be off the middle between the two, towards the next [rad]
  double spread = 0.0;               ///< standard deviation of single beams about the fit [m]
  double slope = 0.0;                ///< change of range with tilt, the middle one of the beams that tell of it [m/rad]
};

/// @brief A beam against the two beside it in the lines before and after.
struct LineSample {
  float error;    ///< range less what a plane through the two predicts half-way between them [m]
  float slope;    ///< change of range with tilt; 0 if it is hardly more than noise [m/rad]
  float between;  ///< what the beam is said to be off the middle between the two, towards the next line [rad]
  int beam;
};

/// @brief Sets the weights with which the lines `reach` before and after a line predict it, wherever it lies between them.
/// Lines of one direction leave them even. @param line at least `reach` from the first and the last.
void weighNeighbours(const GridLines& lines, int line, int reach, LineMisfit& misfit);

/// @brief Working memory of measureLineMisfit(), which one line after the other may use.
struct LineMisfitMemory {
  std::vector<LineSample> samples;
  std::vector<float> numbers, slopes;
  std::vector<std::pair<float, float>> turns;
};

/// @brief Fits what a line is off, robustly: on a plane inverse range is linear in the direction of the beam, so each beam
/// is predicted by the two beside it. An error of range moves all beams alike, one of tilt in proportion to the slope.
/// @param line neither the first nor the last. @param beams of the line that are looked at, about.
/// @param memory overwritten.
LineMisfit measureLineMisfit(const GridLines& lines, int line, LineErrorKind kind, int beams, LineMisfitMemory& memory);

/// @brief What the sloped beams of a line are off as their directions stand, the middle one [m]; -1 where it is not known.
struct LineOff {
  double by_slopes = -1.0;  ///< against the two beside, half-way between them, and on from there along the slope
  double as_stated = -1.0;  ///< against the two beside, where the beam that moves most is said to lie between its two
};

/// @brief Slopes are means over some lines, and wrong where a line is far off the middle; they do not count in
/// LineOff::as_stated.
/// @param memory as measureLineMisfit() has left it, which has looked for turns of this line.
LineOff offOf(const GridLines& lines, int line, LineMisfitMemory& memory);

}  // namespace ppc
