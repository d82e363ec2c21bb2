// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

/// @brief Plane, centroid, covariance, point count and rms of every region of a label image, whichever method made the
/// labels. The plane minimises errors along the beams, where range noise runs, and small ones across them (BeamStart; total
/// least squares where a region is seen edge-on), without those beyond 2.5 standard deviations: points that got the label
/// from beside the region do not turn it. The covariance takes the residuals' own variance, and points as independent.
/// Centroid, count and rms are those of all points.
/// @param labels values 1..N, 0 = none; same size as the grid.
/// @return one region for each id 1..max that has at least 3 points; in ascending id.
std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const LabelImage& labels, int threads = 1);
std::vector<PlanarRegion> describeRegions(const BeamGrid& grid, const std::vector<LabelRun>& runs, int threads = 1);

/// @brief Renumbers labels to 1..N in descending number of pixels (ties: first pixel first) and clears regions of fewer than
/// `min_size` valid points. @param runs if given, set to those of the new labels, as labelRuns(). @param valid_points if
/// given, set to the number of pixels with a measurement. @return N.
int renumberBySize(const BeamGrid& grid, int min_size, LabelImage& labels, std::vector<LabelRun>* runs = nullptr,
                   int* valid_points = nullptr);

}  // namespace ppc
