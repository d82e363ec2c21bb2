// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

namespace ppc {

/// @brief Number of the k-th line of a sample of one in `stride`, in step with nothing that comes again every few lines.
inline int sampledLine(int k, int stride) { return k * stride + 5 * k % stride; }

/// @brief The lines by which a grid was scanned, one after the other: its rows, or its columns. Keeps a reference to the
/// grid.
class GridLines {
 public:
  GridLines(const BeamGrid& grid, bool in_columns)
      : grid_(grid),
        count_(in_columns ? grid.cols : grid.rows),
        beams_(in_columns ? grid.rows : grid.cols),
        line_step_(in_columns ? 1 : grid.cols),
        beam_step_(in_columns ? grid.cols : 1) {}

  const BeamGrid& grid() const { return grid_; }
  int count() const { return count_; }
  int beams() const { return beams_; }  ///< of a line
  int pixel(int line, int beam) const { return line * line_step_ + beam * beam_step_; }
  int lineStep() const { return line_step_; }  ///< from a pixel to that of the same beam in the next line
  Eigen::Vector3f direction(int line, int beam) const { return grid_.direction(pixel(line, beam)); }

  /// @brief Two lines some way before and after a line.
  struct Span {
    int before, after;
    double angle;  ///< between the two, of the beam that moves most, as those near the axis hardly do [rad]
  };
  Span spanAround(int line) const;

  /// What moves a beam from the first line of a span to the last.
  Eigen::Vector3f chord(const Span& span, int beam) const {
    return direction(span.after, beam) - direction(span.before, beam);
  }

 private:
  const BeamGrid& grid_;
  int count_, beams_, line_step_, beam_step_;
};

}  // namespace ppc
