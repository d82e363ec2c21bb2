// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Finds points amid a region that are none of its plane. Thread-safe, for different cells; the arguments must
/// outlive the object.
class CellOutliers {
 public:
  /// @param planes by label, see labelPlanes(). @param center origin of the cells' moments and of the planes [m].
  CellOutliers(const BeamGrid& grid, const Eigen::Vector3d& center, const std::vector<Eigen::Vector3d>& planes,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance)
      : grid_(grid), center_(center), planes_(planes), noise_(noise), tolerance_(tolerance) {}

  /// Fetches what clear() will read of most cells into the cache, while something else is done.
  void prefetch(const Patch& cell) const;

  /// Clears the pixels of a cell that its only label, which all its valid pixels have, does not explain. The cell's moments
  /// must be weighed with the noise at its mean range (weighPatches). @return whether there are any.
  bool clear(const Patch& cell, std::int32_t label, LabelImage& out) const;

 private:
  bool mayHaveAny(const Patch& cell, std::int32_t label, int middle) const;

  const BeamGrid& grid_;
  const Eigen::Vector3d& center_;
  const std::vector<Eigen::Vector3d>& planes_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
};

}  // namespace ppc
