// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/similarity.h"

#include <vector>

namespace ppc {

/// @brief Variance of the distance between a point and a plane along the beam, by range: noise, and what planes are allowed.
class DistanceVariance {
 public:
  void set(const NoiseModel& noise, const CoplanarityTolerance& tolerance) {
    variances_.resize(NoiseModel::kCells);
    for (int cell = 0; cell < NoiseModel::kCells; ++cell) {
      const double sigma = noise.sigma((cell + 0.5) / NoiseModel::kCellsPerMetre);
      const double floor = tolerance.forNoise(sigma).sigma_distance;
      variances_[static_cast<std::size_t>(cell)] = static_cast<float>(sigma * sigma + floor * floor);
    }
  }

  /// [m^2]; that of range 0 where there is none. Precondition: set().
  Lanes at(Lanes range) const {
    constexpr auto kScale = static_cast<float>(NoiseModel::kCellsPerMetre), kLast = NoiseModel::kCells - 1.0F;
    const Lanes scaled = range * kScale;
    const Lanes above = scaled > Lanes{} ? scaled : Lanes{};  // not if it is no number
    const LaneMask cell = __builtin_convertvector(above < fill(kLast) ? above : fill(kLast), LaneMask);
    const float* const table = variances_.data();
    return Lanes{table[cell[0]], table[cell[1]], table[cell[2]], table[cell[3]]};
  }

 private:
  std::vector<float> variances_;
};

}  // namespace ppc
