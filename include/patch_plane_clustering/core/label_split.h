// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/moments.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/similarity.h"

#include <vector>

namespace ppc {

/// @brief A label's cells on two sides, and a plane for each.
struct LabelSplit {
  struct Side {
    Moments sum;  ///< weighed with the noise
    PlaneFit fit;
  };

  std::vector<char> beyond;  ///< for every cell, whether it is on the high side
  Side low, high;

  /// Fits both sides to their sums.
  void fit();
  /// Points of the smaller side.
  int smaller() const;
  /// Within 3.6 degrees.
  bool areParallel() const;
  /// Chi-square that two planes leave beyond what there would be on average.
  double leftOver() const;
  /// Chi-square that two planes take off that of one.
  double explained(const PlaneFit& whole) const;
  /// Chi-square beyond the average that noise may leave.
  double noise(const CoplanarityTolerance& tolerance) const;
  /// Whether both sides on one plane would be a misfit.
  bool isBeyond(const CoplanarityTolerance& tolerance, const NoiseModel& noise, const PlaneFit& whole) const;
};

}  // namespace ppc
