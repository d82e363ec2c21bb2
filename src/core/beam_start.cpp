// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_start.h"

#include "patch_plane_clustering/core/across_fit.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr int kSample = 512;    // points
constexpr int kSampleRun = 16;  // neighbours among them
constexpr int kMaxSteps = 8;
constexpr int kMaxTrimmedSteps = 4;             // if the sample is the region; one, if there are points to come
constexpr double kSettled = 0.2;                // gain of a step, in variances of the errors
constexpr int kFewest = 64;                     // points, for errors to have a distribution
constexpr double kTrim = 2.5;                   // standard deviations
constexpr double kSigmaOfMedian = 1.482602219;  // of absolute errors
constexpr double kRounding = 1e-5;              // of the range, in single precision
constexpr double kEdgeOn = 30.0;                // times as far off the plane along the beams as off that across
constexpr double kExact = 1e-4;                 // of the range: errors that do not matter

std::vector<PixelBlock> sampleOf(const std::vector<PixelBlock>& blocks) {
  long long pixels = 0;
  for (const PixelBlock& block : blocks) pixels += block.end - block.begin;
  if (pixels <= kSample) return blocks;
  std::vector<PixelBlock> sample;
  constexpr int kRuns = kSample / kSampleRun;
  sample.reserve(kRuns);
  long long before = 0, taken = 0, next = 0;
  for (const PixelBlock& block : blocks) {
    const int length = block.end - block.begin;
    for (; next < before + length; next = ++taken * pixels / kRuns) {
      const int begin = block.begin + static_cast<int>(next - before);
      sample.push_back({begin, std::min(begin + kSampleRun, block.end)});
    }
    before += length;
  }
  return sample;
}

int firstValid(const BeamGrid& grid, const std::vector<PixelBlock>& blocks) {
  for (const PixelBlock& block : blocks) {
    for (int i = block.begin; i < block.end; ++i) {
      if (grid.valid(i)) return i;
    }
  }
  return -1;
}

// Half of the points are nearer to the plane, along the beams [m].
double medianError(const BeamGrid& grid, const std::vector<PixelBlock>& blocks, const Plane& plane) {
  const Lanes nx = fill(static_cast<float>(plane.normal.x())), ny = fill(static_cast<float>(plane.normal.y())),
              nz = fill(static_cast<float>(plane.normal.z())), d = fill(static_cast<float>(plane.d));
  std::vector<float> errors;
  errors.reserve(kSample);
  for (const PixelBlock& block : blocks) {
    for (int i = block.begin; i < block.end; i += kLanes) {
      const BeamLanes beam(grid, i, block.end - i);
      const Lanes cosine = nx * beam.dir_x + ny * beam.dir_y + nz * beam.dir_z;
      const Lanes height = nx * beam.origin_x + ny * beam.origin_y + nz * beam.origin_z - d;
      const Lanes error = beam.range + height / cosine;
      for (int k = 0; k < kLanes; ++k) {
        if (beam.valid[k] != 0) errors.push_back(std::abs(error[k]));
      }
    }
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace

BeamStart startOf(const BeamGrid& grid, const std::vector<PixelBlock>& blocks) {
  BeamStart start;
  const std::vector<PixelBlock> sample = sampleOf(blocks);
  const int first = firstValid(grid, sample);
  if (first < 0) return start;
  PointSums points;
  const Eigen::Vector3d about = grid.point(first).cast<double>();
  start.origin = grid.origin(first).cast<double>();
  for (const PixelBlock& block : sample) addPoints(grid, block.begin, block.end, about, points);
  if (points.n < 3) return start;
  const PlanarRegion across = fitAcross(0, about, points);
  const Eigen::Vector3d towards(-points.ux, -points.uy, -points.uz);
  const double distance = (across.centroid - start.origin).norm();

  const auto sum = [&](BeamWeights weights) {
    return sumBeams(grid, sample.data(), sample.data() + sample.size(), start.frame, weights, start.limit);
  };
  const auto moveTo = [&](const Plane& plane) {
    if (!plane.normal.allFinite() || !std::isfinite(plane.d) || !(plane.normal.dot(towards) > 0.0)) return false;
    start.frame = BeamFrame(plane, across.centroid);
    return true;
  };
  double rms = 0.0;  // across the plane before the last step
  const auto settle = [&](BeamWeights weights, int steps) {
    for (int k = 0; k < steps; ++k) {
      const BeamSums sums = sum(weights);
      const std::optional<BeamStep> step =
          stepOf(sums, weights == BeamWeights::kTrimmed ? newtonScale(sums, start.limit) : 1.0);
      if (!step || sums.kept < std::max(4, sums.valid / 2) || !moveTo(movedBy(*step, start.frame, start.origin)))
        return false;
      rms = std::sqrt(sums.hh / sums.valid);
      if (step->gain * sums.kept <= kSettled * sums.whh) break;
    }
    return true;
  };
  const Eigen::Vector3d facing = towards.normalized();
  if (!moveTo({facing, facing.dot(across.centroid)})) return start;
  const std::optional<BeamStep> step = stepOf(sum(BeamWeights::kInverse));
  if (!step || !moveTo(movedBy(*step, start.frame, start.origin))) return start;
  if (!settle(BeamWeights::kNear, kMaxSteps)) return start;
  if (rms > kEdgeOn * across.rms && rms > kExact * distance) return start;
  start.along = true;
  start.limit = kNoLimit;
  if (points.n < kFewest) return start;
  const BeamStart untrimmed = start;
  start.limit = kTrim * kSigmaOfMedian * medianError(grid, sample, start.frame.plane()) + kRounding * distance;
  return settle(BeamWeights::kTrimmed, sample.size() == blocks.size() ? kMaxTrimmedSteps : 1) ? start : untrimmed;
}

}  // namespace ppc
