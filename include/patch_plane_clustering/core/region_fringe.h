// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_fit.h"
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/core/row_runs.h"

#include <Eigen/Core>

#include <array>
#include <initializer_list>
#include <vector>

namespace ppc {

/// @brief Working memory of Fringe, which one region after the other may use.
struct FringeMemory {
  std::vector<LabelRun> runs;             ///< of the region
  RowRuns rows;                           ///< the same, cut at rows
  std::array<std::vector<int>, 4> sides;  ///< pixels whose neighbour above, below, before, after is not of the region
  std::vector<int> pixels;                ///< of all sides, or of parts that are off
  std::vector<PixelStretch> stretches;    ///< the same, neighbours joined
};

/// @brief A plane by which a fringe is judged.
struct FringeJudge {
  Plane plane;
  double sigma = 0.0;         ///< standard deviation of the errors as ErrorScale weighs them [m]
  double significance = 3.0;  ///< of the mean error of a part that is off, in its standard deviations
  /// Of a plane that the fringe had no part in: the standard deviation of how far a part of the same face may stand off it,
  /// across it, as walls bow [m], and the covariance of its (n, d).
  double tolerance = 0.0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// @brief The fringe of a region: its pixels on each of four sides. Finds those parts of it that lie off a plane to one
/// side.
///
/// Where a border is drawn a pixel too far, points of what is beside the region lie along it: each of them within the noise,
/// and all of them on the same side. A few hundredths of a region turn its plane by several degrees if it is as narrow as
/// the noise is large, like the riser of a stair. Each side is looked at in parts of about 16 pixels; a part is off if the
/// mean of its errors, each capped at ErrorScale::limit, is further from 0 than its judge's standard deviations allow. No
/// single error decides, so that what is left has a distribution of errors as wide as before.
class Fringe {
 public:
  /// @param begin,end blocks of the region, in scan order. @param memory in use as long as this is.
  Fringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, FringeMemory& memory);

  /// All its pixels, in scan order, each once. In memory until the next call.
  const std::vector<PixelStretch>& all();

  /// The pixels of parts that any judge finds off, likewise. @param scale the limit and how errors count.
  const std::vector<PixelStretch>& off(std::initializer_list<FringeJudge> judges, const ErrorScale& scale);

 private:
  const std::vector<PixelStretch>& joinPixels();

  const BeamGrid& grid_;
  FringeMemory& memory_;
};

}  // namespace ppc
