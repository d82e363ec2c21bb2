// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/point_square.h"

#include <cmath>

namespace ppc {

std::optional<PointSquare> PointSquare::around(const BeamGrid& grid, int pixel, int row_stride, int col_stride) {
  const int top = pixel / grid.cols - (kSide - 1) * row_stride / 2, left = pixel % grid.cols - (kSide - 1) * col_stride / 2;
  if (top < 0 || left < 0) return {};
  if (top + (kSide - 1) * row_stride >= grid.rows || left + (kSide - 1) * col_stride >= grid.cols) return {};
  PointSquare square(grid, grid.index(top, left), row_stride * grid.cols, col_stride);
  square.about_ = grid.origin(pixel).cast<double>();
  Moments moments;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) {
      const int i = square.pixel(row, col);
      if (!grid.valid(i)) return {};
      addPoint(grid, i, square.about_, moments);
    }
  }
  square.fit_ = fitPlane(moments);
  return square;
}

double PointSquare::residual() const { return std::sqrt(fit_.chi2 / (kSide * kSide - 3)); }

double PointSquare::correlation(int down, int right) const {
  double errors[kSide][kSide], squares = 0.0, products = 0.0;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) {
      const int i = pixel(row, col);
      const Eigen::Vector3d p = grid_.point(i).cast<double>() - about_;
      const double error = grid_.range[i] * (1.0 - fit_.a.dot(p));
      squares += error * error;
      if (row >= down && col >= right) products += error * errors[row - down][col - right];
      errors[row][col] = error;
    }
  }
  constexpr double kPairs = static_cast<double>(kSide * (kSide - 1)) / (kSide * kSide);  // over points
  return squares > 0.0 ? products / (kPairs * squares) : 0.0;
}

void addPoint(const BeamGrid& grid, int pixel, const Eigen::Vector3d& about, Moments& moments) {
  const Eigen::Vector3d p = grid.point(pixel).cast<double>() - about;
  const double range = grid.range[pixel];
  moments.add(p.x(), p.y(), p.z(), range * range);
}

}  // namespace ppc
