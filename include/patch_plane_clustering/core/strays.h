// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <array>
#include <vector>

namespace ppc {

/// @brief How far ranges may be off their neighbours': five standard deviations of the noise, by range. It is told by what
/// most pixels of a column are off the middle of the two beside them, so that neither strays nor edges matter.
class StrayLimits {
 public:
  /// @param sampled rows of the grid, all of them with one before and one after. @param differences scratch, overwritten.
  void measure(const BeamGrid& grid, const std::vector<int>& sampled, std::vector<std::vector<float>>& differences);
  /// @param range [m] @return [m]
  float at(float range) const;

 private:
  static constexpr int kBins = 64;  // two an octave
  std::array<float, kBins> sigma_{};
};

/// @brief Working memory of clearStrays(), which one image after the other may use.
struct StrayMemory {
  std::vector<int> sampled;                     ///< rows
  std::vector<std::vector<float>> differences;  ///< of each range, see StrayLimits
  StrayLimits limits;
  std::vector<float> ranges;  ///< of one round
  BeamGrid grid;              ///< the image without strays
};

/// @brief Looks for strays: single points that lie nowhere near their neighbours, as dust, rain, sunlight and edges make
/// them. A point is one if, of all its neighbours but one, each is farther than the point is by more than a limit
/// (StrayLimits), or each is nearer. So points of a surface seen at a grazing angle are none, nor are those of a line.
///
/// Points that are none of a surface are left without a label in any case; but where some in a hundred are strays,
/// most patches contain some, hence fit no plane, and those are worst off that are large, towards the pole of the scan.
/// @return whether there are that many, by a sample of rows; then memory.grid is the image without them.
bool clearStrays(const BeamGrid& grid, StrayMemory& memory, int threads = 1);

}  // namespace ppc
