// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/sensor_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Working memory of NoiseModel::estimate(), which one image after the other may use.
struct NoiseMemory {
  std::vector<int> bin;                    ///< of each patch, -1 if it is left out
  std::vector<double> variance;            ///< of each patch
  std::vector<int> bin_begin;              ///< of each bin's part of `variances`, and one past the last
  std::vector<double> variances;           ///< of the patches, bin by bin
  std::vector<std::vector<double>> pools;  ///< those of a bin and of its neighbours; one list a thread
  std::vector<double> sigma;               ///< of each bin [m]
  std::vector<char> sure;                  ///< bins whose patches are alike
};

/// @brief Range noise as a function of range: from the sensor model, or estimated from an image.
class NoiseModel {
 public:
  /// It is the same within each of so many cells of range, the last of which has no end.
  static constexpr int kCells = 4096;
  static constexpr double kCellsPerMetre = 32.0;
  /// Surfaces of less noise than so many times the typical one are typical.
  static constexpr double kLeastFactor = 1.265;

  /// Noise of a data sheet times a factor.
  NoiseModel(const SensorModel& sensor, double scale);

  /// @brief Estimates the noise from the residuals of small patches: most of them lie on surfaces that are flat over their
  /// width, and a low quantile leaves the others out; what other ranges tell bounds it, closely where not even a quarter of
  /// the patches at a range are alike. Seen over several lines at once, the residuals contain noise that is correlated along
  /// a line, and errors that a whole line shares; differences along the line would be blind to both.
  static NoiseModel estimate(const PatchGrid& patches, const SensorModel& sensor);
  static NoiseModel estimate(const PatchGrid& patches, const SensorModel& sensor, NoiseMemory& memory, int threads = 1);

  /// One standard deviation [m] at a range [m]: of a typical surface, if surfaces differ.
  double sigma(double range) const {
    return table_[static_cast<std::size_t>(std::min(std::max(range * kCellsPerMetre, 0.0), kCells - 1.0))];
  }

  /// @brief From now on, the noise of a pixel is so many times the typical one at its range (see surface_noise.h).
  /// @param factors of the pixels, at least 1; must outlive the model and its copies.
  void setFactors(const std::vector<float>& factors) { factors_ = &factors; }

  /// Noise at a pixel over the typical one at its range.
  float factorAt(int pixel) const { return factors_ == nullptr ? 1.0F : (*factors_)[static_cast<std::size_t>(pixel)]; }

  /// The standard deviation of a pixel [m]. @param range of it [m].
  double sigmaAt(int pixel, double range) const { return sigma(range) * factorAt(pixel); }

  /// The standard deviation of points that moments are of [m]: where surfaces differ, their weights tell, if by more than
  /// ranges that differ make of it. @param range of the points [m].
  double sigmaOf(const Moments& weighed, double range) const {
    const double typical = sigma(range);
    if (factors_ == nullptr) return typical;
    const double squares = weighed.xx + weighed.yy + weighed.zz;  // about w r^2
    const double sigma = std::sqrt(weighed.n * squares) / weighed.w;
    return sigma > kLeastFactor * typical ? sigma : typical;
  }

  /// Multiplies it at all ranges.
  void scale(double factor) {
    for (double& sigma : table_) sigma *= factor;
  }

 private:
  explicit NoiseModel(const std::vector<double>& sigma_of_bin);

  std::array<double, kCells> table_{};           // looked up once or more a point: no logarithm there
  const std::vector<float>* factors_ = nullptr;  // of the pixels; none if surfaces do not differ
};

}  // namespace ppc
