// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/core/quadratic_fit.h"
#include "patch_plane_clustering/core/segmentation.h"
#include "patch_plane_clustering/core/similarity.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ppc {

/// @brief How a region bends: the quadratic surface z = c0 + c1 s + c2 t + c3 s^2 + c4 s t + c5 t^2 over its own plane.
struct Bend {
  double turn = 0.0;       ///< angle between the normals at its two ends, along the direction of strongest curvature [rad]
  double excess = 0.0;     ///< chi-square of the plane less that of the quadratic surface (3 degrees of freedom)
  double amplitude = 0.0;  ///< root mean square of the quadratic part [m]
};

/// @brief A region: its plane by total least squares, and samples near that plane.
struct SampledRegion {
  int points = 0;
  int stride = 1;  ///< pixels a sample stands for
  Plane plane;
  Bend bend;
  SurfaceSamples samples;
};

/// @brief What is needed of sampled pixels until their plane is known, beside their points.
struct SampledBeams {
  std::vector<float> ux, uy, uz;  ///< directions
  std::vector<float> sigma;       ///< of the range [m]
};

/// @brief Working memory of planarNames(), which one image after the other may use.
struct CurvatureMemory {
  std::vector<int> count, begin, end, next;  ///< of each label: pixels, its part of `pixels`, those until its next sample
  std::vector<int> pixels;                   ///< that are sampled, label by label
  std::vector<float> columns;                ///< of the samples, region by region
  std::vector<SampledRegion> regions;        ///< index = label
  std::vector<SampledBeams> beams;           ///< one a thread
  std::vector<std::pair<std::int32_t, std::int32_t>> touching;  ///< labels
  std::vector<char> curved, weak, alone, certain;               ///< what is known of each label
  std::vector<int> host_points;
};

/// @brief Bends of the regions of a label image; index = label (0 unused). From at most a few thousand points a region.
std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise);

/// @brief Tells planar regions from pieces of curved surfaces: strips of a cylinder, caps of a sphere.
///
/// A region is curved if its normal turns by more than `max_turn` from end to end *and* the bend is beyond noise and
/// tolerance. The turn tells a cylinder (a strip as thick as the noise still turns by tenths of a radian) from a real wall,
/// which may bow by a centimetre over several metres. Touching regions that meet at an angle are strips of one curved
/// surface if one quadratic surface serves both; at the crease of two planes it does not (of an evenly sampled one, a
/// sixteenth of what one plane leaves remains). So come the halves of a thin column in much noise, nearly at right angles;
/// strips at its limbs, beside one that is found curved, need only come near one such surface.
/// @param runs of the labels.
/// @param names set for every label to itself if it is planar, 0 if it is curved, or the label of the plane whose soft edge
/// it is.
void planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                 const LabelImage& labels, const std::vector<LabelRun>& runs, CurvatureMemory& memory,
                 std::vector<std::int32_t>& names, int threads = 1);

/// @brief The same without memory. @return the names.
std::vector<std::int32_t> planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double max_turn, const LabelImage& labels, const std::vector<LabelRun>& runs,
                                      int threads = 1);

}  // namespace ppc
