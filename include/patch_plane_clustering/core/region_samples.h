// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/core/quadratic_fit.h"

#include <vector>

namespace ppc {

/// @brief A region: its plane, at first by total least squares, and samples near that plane.
struct RegionSamples {
  int points = 0;      ///< of the region; 0 if too few of its pixels were sampled for a plane
  int stride = 1;      ///< pixels a sample stands for
  double sigma = 0.0;  ///< noise of the ranges in its middle [m]
  Plane plane;
  SurfaceSamples samples;
};

/// @brief What is needed of sampled pixels until their plane is known, beside their points.
struct SampledBeams {
  std::vector<float> ux, uy, uz;  ///< directions
  std::vector<float> sigma;       ///< of the range [m]
};

/// @brief Working memory of samples of all regions of an image.
struct SampleMemory {
  std::vector<RegionSamples> regions;        ///< index = label
  std::vector<int> count, begin, end, next;  ///< of each label: pixels, its part of `pixels`, those until its next sample
  std::vector<int> pixels;                   ///< that are sampled, label by label
  std::vector<float> columns;                ///< of the samples, region by region
};

/// @brief Chooses pixels of every label, evenly and at most a few thousand, and makes room for the samples of those that
/// have at least three of them. @param runs of the labels.
void chooseSamples(const BeamGrid& grid, const std::vector<LabelRun>& runs, SampleMemory& memory);

/// @brief Reads the samples of a region of more than 0 points, and fits its plane. For several regions at a time, each with
/// beams of its own.
void sampleRegion(const BeamGrid& grid, const NoiseModel& noise, int label, SampledBeams& beams, SampleMemory& memory);

}  // namespace ppc
