// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/similarity.h"

#include <vector>

namespace ppc {

/// @brief Variance of the distance between a point and a plane along the beam: noise, and what planes are allowed. By range,
/// from a table, but for surfaces of more than the typical noise.
class DistanceVariance {
 public:
  /// The arguments must outlive the calls of at().
  void set(const NoiseModel& noise, const CoplanarityTolerance& tolerance) {
    noise_ = &noise;
    tolerance_ = &tolerance;
    variances_.resize(NoiseModel::kCells);
    for (int cell = 0; cell < NoiseModel::kCells; ++cell) {
      variances_[static_cast<std::size_t>(cell)] = varianceOf(noise.sigma((cell + 0.5) / NoiseModel::kCellsPerMetre));
    }
  }

  /// [m^2]; that of range 0 where there is none. Precondition: set(). @param pixel of the first: all are taken to be
  /// on the same surface.
  Lanes at(Lanes range, int pixel) const {
    constexpr auto kScale = static_cast<float>(NoiseModel::kCellsPerMetre), kLast = NoiseModel::kCells - 1.0F;
    const Lanes scaled = range * kScale;
    const Lanes above = scaled > Lanes{} ? scaled : Lanes{};  // not if it is no number
    const LaneMask cell = __builtin_convertvector(above < fill(kLast) ? above : fill(kLast), LaneMask);
    const float* const table = variances_.data();
    Lanes variances{table[cell[0]], table[cell[1]], table[cell[2]], table[cell[3]]};
    const double factor = noise_->factorAt(pixel);
    if (factor == 1.0) return variances;
    for (int k = 0; k < kLanes; ++k) {
      variances[k] = varianceOf(factor * noise_->sigma((cell[k] + 0.5) / NoiseModel::kCellsPerMetre));
    }
    return variances;
  }

 private:
  float varianceOf(double sigma) const {
    const double floor = tolerance_->forNoise(sigma).sigma_distance;
    return static_cast<float>(sigma * sigma + floor * floor);
  }

  const NoiseModel* noise_ = nullptr;
  const CoplanarityTolerance* tolerance_ = nullptr;
  std::vector<float> variances_;
};

}  // namespace ppc
