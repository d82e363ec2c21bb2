// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/point_square.h"

#include <cmath>

namespace ppc {
namespace {

constexpr double kExact = 3e-5;  // of the range: what single precision and the ridge of solvePlane() leave is less

}  // namespace

bool PointSquare::isMeasured(const BeamGrid& grid, int pixel, int row_stride, int col_stride) {
  const PointSquare square(grid, pixel, row_stride, col_stride);
  const int bottom = square.top_ + (kSide - 1) * row_stride, right = square.left_ + (kSide - 1) * col_stride;
  if (square.top_ < 0 || square.left_ < 0 || bottom >= grid.rows || right >= grid.cols) return false;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) {
      if (!grid.valid(square.pixel(row, col))) return false;
    }
  }
  return true;
}

std::optional<PointSquare> PointSquare::around(const BeamGrid& grid, int pixel, int row_stride, int col_stride) {
  if (!isMeasured(grid, pixel, row_stride, col_stride)) return {};
  PointSquare square(grid, pixel, row_stride, col_stride);
  square.about_ = grid.origin(pixel).cast<double>();
  Moments moments;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) addPoint(grid, square.pixel(row, col), square.about_, moments);
  }
  square.fit_ = fitPlane(moments);
  return square;
}

double PointSquare::residual() const { return std::sqrt(fit_.chi2 / (kSide * kSide - 3)); }

PointSquare::PointSquare(const BeamGrid& grid, int pixel, int row_stride, int col_stride)
    : grid_(grid),
      row_stride_(row_stride),
      col_stride_(col_stride),
      top_(pixel / grid.cols - (kSide - 1) * row_stride / 2),
      left_(pixel % grid.cols - (kSide - 1) * col_stride / 2) {}

double PointSquare::correlation(int down, int right) const {
  if (residual() < kExact * grid_.range[pixel(0, 0)]) return 0.0;
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
  return products / (kPairs * squares);
}

void addPoint(const BeamGrid& grid, int pixel, const Eigen::Vector3d& about, Moments& moments) {
  const Eigen::Vector3d p = grid.point(pixel).cast<double>() - about;
  const double range = grid.range[pixel];
  moments.add(p.x(), p.y(), p.z(), range * range);
}

}  // namespace ppc
