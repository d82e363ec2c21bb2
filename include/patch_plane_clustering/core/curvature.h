// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/bend.h"
#include "patch_plane_clustering/core/label_pairs.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/region_samples.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Working memory of planarNames(), which one image after the other may use.
struct CurvatureMemory {
  SampleMemory samples;
  std::vector<Bend> bends;          ///< index = label
  std::vector<SampledBeams> beams;  ///< one a thread
  RowRuns runs;
  LabelPairIndex pairs;
  std::vector<std::pair<std::int32_t, std::int32_t>> touching;  ///< labels
  std::vector<char> fans;                                       ///< of those: are strips of one curved surface
  std::vector<char> curved, weak, alone, certain;               ///< what is known of each label
  std::vector<int> host_points;
};

/// @brief Bends of the regions of a label image; index = label (0 unused). From at most a few thousand points a region.
std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise);

/// @brief Tells planar regions from pieces of curved surfaces: strips of a cylinder, caps of a sphere.
///
/// A region is curved if its normal turns by more than `max_turn` from end to end *and* the bend is beyond noise and
/// tolerance; three quarters of that turn do if the bend is far beyond both, but for smooth noise. The turn tells a cylinder
/// (a strip as thick as the noise still turns by tenths of a radian) from a real wall, which may bow by a centimetre over
/// several metres. Touching regions that meet at an angle are strips of one curved surface if one quadratic surface serves
/// both; at the crease of two planes it does not (of an evenly sampled one, a sixteenth of what one plane leaves remains).
/// So come the halves of a thin column in much noise, nearly at right angles; strips at its limbs, beside one that is found
/// curved, need only come near one such surface, and those that bend a little need only be at its range. In white noise,
/// less of a bend does for that.
/// @param memory as prepareCurvature() has left it for the labels.
/// @param names set for every label to itself if it is planar, 0 if it is curved, or the label of the plane whose soft edge
/// it is.
void planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                 CurvatureMemory& memory, std::vector<std::int32_t>& names, int threads = 1);

/// @brief Chooses samples of the labels, and finds those that touch. @param runs of an image as large as the grid.
void prepareCurvature(const BeamGrid& grid, const std::vector<LabelRun>& runs, CurvatureMemory& memory);

/// @brief Both, without memory. @return the names.
std::vector<std::int32_t> planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double max_turn, const std::vector<LabelRun>& runs, int threads = 1);

}  // namespace ppc
