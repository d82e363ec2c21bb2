// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/image_errors.h"

#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/noise_correlation.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/patch_sample.h"
#include "patch_plane_clustering/core/range_limit.h"
#include "patch_plane_clustering/core/smooth_noise.h"
#include "patch_plane_clustering/core/surface_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {
namespace {

// What correlated errors do to the noise, if it is estimated, and to the tolerance. Returns whether anything.
bool estimateCorrelation(const Config& config, ClusteringMemory& memory, ImageErrors& errors) {
  PatchGrid& patches = memory.patches;
  CoplanarityTolerance& tolerance = errors.tolerance;
  forEachPart(config.threads, kSampleParts, [&](int part) {
    sampleInflation(patches, part, memory.inflation);
    sampleCorrelation(patches, part, memory.correlation);
  });
  tolerance.inflation = inflationOf(memory.inflation);
  const NoiseCorrelation found = correlationOf(memory.correlation, tolerance.inflation);
  tolerance.inflation_growth = found.growth;
  tolerance.patch_points = found.points;
  if (config.noise_scale > 0.0 || found.variance == 1.0) return tolerance.inflation != 1.0 || found.growth > 0.0;
  errors.noise.scale(std::sqrt(found.variance));
  tolerance.inflation = std::max(1.0, tolerance.inflation / found.variance);
  for (Patch& patch : patches.patches) patch.weigh(found.variance);
  return true;
}

// At the ranges of planar patches, the mean over a sample of them [m].
double typicalNoise(const PatchGrid& patches, const NoiseModel& noise) {
  constexpr int kSamples = 1000;
  double sum = 0.0;
  int count = 0;
  for (int part = 0; part < kSampleParts; ++part) {
    forEachSample(static_cast<int>(patches.patches.size()), kSamples, part, [&](int k) {
      const Patch& patch = patches.patches[k];
      if (!patch.planar) return;
      sum += noise.sigma(patch.range);
      ++count;
    });
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

}  // namespace

ImageErrors estimateErrors(const BeamGrid& grid, double line_error_left, const Config& config, ClusteringMemory& memory) {
  PatchGrid& patches = memory.patches;
  const bool known = config.noise_scale > 0.0;
  CoplanarityTolerance tolerance{std::hypot(config.sigma_distance, line_error_left), config.sigma_angle, 1.0};
  tolerance.least_distance = line_error_left;
  ImageErrors errors{known ? NoiseModel(config.sensor, config.noise_scale)
                           : NoiseModel::estimate(patches, config.sensor, memory.noise, config.threads),
                     tolerance,
                     {}};
  const auto gate = [&] { gatePatches(errors.noise, errors.tolerance, patches, config.threads); };
  weighAndGatePatches(errors.noise, errors.tolerance, patches, config.threads);
  if (!config.noise_aware) return errors;
  if (config.noise_by_surface && !known &&
      adaptToSurfaces(grid, patches, errors.noise, memory.surface_noise, config.threads)) {
    gate();
  }
  if (estimateCorrelation(config, memory, errors)) gate();
  if (!errors.tolerance.isWhite()) errors.tolerance.alike_around = areErrorsAlikeAround(grid, memory.smooth);
  if (config.avoid_range_limit) errors.range_limit = findRangeLimit(patches, errors.noise);
  markTruncated(grid, errors.range_limit, errors.noise, patches);
  errors.typical = typicalNoise(patches, errors.noise);
  return errors;
}

}  // namespace ppc
