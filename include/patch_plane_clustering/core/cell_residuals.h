// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/similarity.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {

/// @brief The valid pixel nearest to the middle of a cell, in scan order; -1 if there is none.
inline int middlePixel(const BeamGrid& grid, const Patch& cell) {
  const int width = cell.col_end - cell.col_begin, rows = cell.row_end - cell.row_begin, size = width * rows;
  const int middle = grid.index(cell.row_begin + rows / 2, cell.col_begin + rows % 2 * (width / 2));  // pixel(size / 2)
  if (size > 0 && grid.valid(middle)) return middle;  // nearly always, and without a division
  const auto pixel = [&](int k) { return grid.index(cell.row_begin + k / width, cell.col_begin + k % width); };
  for (int step = 0; step <= size / 2; ++step) {
    if (size / 2 + step < size && grid.valid(pixel(size / 2 + step))) return pixel(size / 2 + step);
    if (grid.valid(pixel(size / 2 - step))) return pixel(size / 2 - step);
  }
  return -1;
}

/// @brief What residuals in a cell have in common, whatever the plane: noise and tolerance change little over a cell, and
/// are taken at one pixel.
struct CellNoise {
  Eigen::Vector3f direction;
  float variance, tolerance2;  ///< [m^2]

  CellNoise(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, int pixel)
      : direction(grid.direction(pixel)) {
    const auto sigma = static_cast<float>(noise.sigmaAt(pixel, grid.range[pixel]));
    const auto distance = static_cast<float>(tolerance.forNoise(sigma).sigma_distance);
    variance = sigma * sigma;
    tolerance2 = distance * distance;
  }
};

/// @brief Squared residuals of the pixels of a cell against one plane, in units of their variance.
class CellResiduals {
 public:
  /// @param a the plane a . p = 1 about `center`.
  CellResiduals(const CellNoise& noise, const Eigen::Vector3f& center, const Eigen::Vector3f& a)
      : a_x_(fill(a.x())), a_y_(fill(a.y())), a_z_(fill(a.z())), offset_(fill(1.0F + a.dot(center))) {
    const float along = a.dot(noise.direction);
    const float sec2 = std::min(static_cast<float>(kMaxSecant2), a.squaredNorm() / (along * along));
    const float variance = noise.variance + noise.tolerance2 * sec2;
    precision_ = fill(1.0F / variance);
    variance_ratio_ = variance / noise.variance;
  }

  /// Infinite where nothing was measured, or the plane is not in front of the sensor.
  Lanes operator()(const BeamLanes& beam) const {
    const Lanes along = alongOf(beam);
    const Lanes model = acrossOf(beam) / along;
    const Lanes e = beam.range - model;
    const LaneMask ahead = beam.valid & (model > Lanes{});
    return ahead ? e * e * precision_ : fill(std::numeric_limits<float>::infinity());
  }

  /// @brief Tells quickly which pixels may have a squared residual above a limit: all that have, and those close to it.
  class Limit {
   public:
    Limit(const CellResiduals& residuals, float limit)
        : residuals_(residuals), square_(0.99F * limit / residuals.precision_) {}

    LaneMask mayExceed(const BeamLanes& beam) const {
      const Lanes along = residuals_.alongOf(beam), across = residuals_.acrossOf(beam);
      const Lanes e = beam.range * along - across;  // times the cosine, so that nothing needs to be divided
      const LaneMask within = (e * e <= square_ * along * along) & (across * along > Lanes{});
      return beam.valid & ~within;
    }

   private:
    const CellResiduals& residuals_;
    Lanes square_;
  };

  /// Logarithm of the variance over that of the noise alone: a lenient plane explains everything, but nothing well.
  float logVariance() const { return std::log(variance_ratio_); }

 private:
  Lanes alongOf(const BeamLanes& beam) const { return a_x_ * beam.dir_x + a_y_ * beam.dir_y + a_z_ * beam.dir_z; }
  Lanes acrossOf(const BeamLanes& beam) const {
    return offset_ - (a_x_ * beam.origin_x + a_y_ * beam.origin_y + a_z_ * beam.origin_z);
  }

  Lanes a_x_, a_y_, a_z_, offset_, precision_;
  float variance_ratio_;
};

}  // namespace ppc
