// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/patch_sample.h"

#include <array>
#include <vector>

namespace ppc {

/// @brief What errors that are correlated farther than over a patch do: smooth errors of range cameras, steps of their
/// disparity, errors that lines share. A patch cannot see them, squares of four patches do in part.
struct NoiseCorrelation {
  double variance = 1.0;  ///< variance of the ranges about the planes of squares, over the noise that patches show; from 1
  double growth = 0.0;    ///< exponent with which inflation grows with the number of points, 0..1: CoplanarityTolerance
  double points = 1.0;    ///< of a patch, from which it grows
};

/// @brief Working memory of measureCorrelation(), which one image after the other may use.
struct CorrelationMemory {
  struct Samples {
    std::vector<double> excesses, variances, points;
  };
  std::array<Samples, kSampleParts> parts;  ///< of the squares
};

/// @brief Measures both from low quantiles over squares of planar patches; nothing is found in white noise or in images of
/// less than 100 such pairs of squares, or such squares. @param grid weighed and gated. @param inflation of its patches
/// (estimateInflation).
NoiseCorrelation measureCorrelation(const PatchGrid& grid, double inflation);

/// @brief The same in two steps, of which the first does not need the inflation: all parts [0, kSampleParts),
/// several at a time if there are threads for them. The second uses the samples up.
void sampleCorrelation(const PatchGrid& grid, int part, CorrelationMemory& memory);
NoiseCorrelation correlationOf(CorrelationMemory& memory, double inflation);

}  // namespace ppc
