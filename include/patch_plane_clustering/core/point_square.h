// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/moments.h"

#include <Eigen/Core>
#include <optional>

namespace ppc {

/// @brief 4 x 4 points of an image, so many rows and columns apart, and the plane fitted to them: what its points are off it
/// tells errors from surfaces as far as these are planar over the square. Keeps a reference to the grid.
class PointSquare {
 public:
  /// Whether all of its points are within the image and were measured. @param pixel in the middle, before the half if there
  /// is none; one of an image that has any.
  static bool isMeasured(const BeamGrid& grid, int pixel, int row_stride = 1, int col_stride = 1);

  /// @return none unless isMeasured().
  static std::optional<PointSquare> around(const BeamGrid& grid, int pixel, int row_stride = 1, int col_stride = 1);

  /// Root mean square of what points are off the plane, along their beams [m].
  double residual() const;

  /// Correlation of what neighbours in a row, or in a column, are off the plane: of independent errors some -0.2, for the
  /// plane is fitted to them; 0 if they are off by no more than the arithmetic is.
  double alongRows() const { return correlation(0, 1); }
  double alongColumns() const { return correlation(1, 0); }

 private:
  static constexpr int kSide = 4;

  PointSquare(const BeamGrid& grid, int pixel, int row_stride, int col_stride);
  int pixel(int row, int col) const { return grid_.index(top_ + row * row_stride_, left_ + col * col_stride_); }
  double correlation(int down, int right) const;

  const BeamGrid& grid_;
  int row_stride_, col_stride_, top_, left_;
  Eigen::Vector3d about_;
  PlaneFit fit_;
};

/// @brief Adds a valid point to moments about some point, weighed so that chi-square is the sum of the squares of what
/// points are off along their beams [m^2].
void addPoint(const BeamGrid& grid, int pixel, const Eigen::Vector3d& about, Moments& moments);

}  // namespace ppc
