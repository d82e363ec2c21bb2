// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/surface_fan.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace ppc {
namespace {

constexpr double kMinAmplitude = 0.5;     // of a bend, in tolerances of distance
constexpr double kClearExcess = 3.0;      // of a bend beyond doubt, over what is significant;
constexpr double kClearTurn = 0.75;       // its turn, in max_turn,
constexpr double kClearAmplitude = 0.75;  // and amplitude
constexpr int kStripSizes = 2;            // largest size of such a strip over its neighbour's
constexpr double kWeakTurn = 0.31;        // of a strip beside a curved one, in max_turn
constexpr double kWeakAmplitude = 0.2;    // likewise, in tolerances of distance
constexpr double kWeakExcess = 0.7;       // likewise in white noise, over what is significant
constexpr double kWeakClearTurn = 0.18;   // likewise, if the bend is beyond doubt, in max_turn
constexpr double kEdgeTolerance = 3.0;    // of a bent edge of a plane, in tolerances of distance
constexpr int kEdgeSizes = 4;             // smallest size of that plane over the edge's: what is larger is no edge of it
constexpr double kRangeSlack = 0.1;       // between the ranges of regions that touch, over what both span
constexpr int kMaxGap = 2;                // pixels between regions that touch

// A measured point of a region, about samples.center [m].
Eigen::Vector3d measuredPoint(const SurfaceSamples& samples, std::size_t i) {
  const Eigen::Vector3d foot(samples.x[i], samples.y[i], samples.z[i]);
  return foot + double{samples.height[i]} * samples.normal;
}

// Root mean square distance of samples from a plane, their noise taken out [m].
double misfit(const Plane& plane, const RegionSamples& region) {
  const SurfaceSamples& samples = region.samples;
  const double offset = plane.signedDistance(samples.center);
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size; ++i) {
    if (samples.weight[i] == 0.0F) continue;
    const double distance = offset + plane.normal.dot(measuredPoint(samples, i));
    sum += distance * distance - region.stride / double{samples.weight[i]};
  }
  return std::sqrt(std::max(0.0, sum / std::max(1, samples.used)));
}

struct Span {
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
};

// Distances of a region's samples from the origin, near which the sensor is [m].
Span rangesOf(const RegionSamples& region) {
  const SurfaceSamples& samples = region.samples;
  Span span;
  for (std::size_t i = 0; i < samples.size; ++i) {
    if (samples.weight[i] == 0.0F) continue;
    const double range = (samples.center + measuredPoint(samples, i)).norm();
    span.nearest = std::min(span.nearest, range);
    span.farthest = std::max(span.farthest, range);
  }
  return span;
}

// Whether regions that touch in the image may do so in space too: what is far behind a column is no part of it.
bool mayTouch(const RegionSamples& a, const RegionSamples& b) {
  const Span of_a = rangesOf(a), of_b = rangesOf(b);
  const double slack = kRangeSlack * (of_a.farthest - of_a.nearest + of_b.farthest - of_b.nearest);
  return std::max(of_a.nearest, of_b.nearest) <= std::min(of_a.farthest, of_b.farthest) + slack;
}

// Samples a label of at least three points, and measures how it bends.
void sampleBend(const BeamGrid& grid, const NoiseModel& noise, int label, SampledBeams& beams, SampleMemory& memory,
                std::vector<Bend>& bends) {
  RegionSamples& region = memory.regions[label];
  if (region.points == 0) return;
  sampleRegion(grid, noise, label, beams, memory);
  bends[label] = bendOf(region);
  region.plane = bends[label].plane;
}

}  // namespace

std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  SampleMemory memory;
  chooseSamples(grid, labelRuns(labels), memory);
  SampledBeams beams;
  std::vector<Bend> bends(memory.regions.size());
  for (int label = 0; label < static_cast<int>(bends.size()); ++label) {
    sampleBend(grid, noise, label, beams, memory, bends);
  }
  return bends;
}

std::vector<std::int32_t> planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double max_turn, const std::vector<LabelRun>& runs, int threads) {
  CurvatureMemory memory;
  std::vector<std::int32_t> names;
  prepareCurvature(grid, runs, memory);
  planarNames(grid, noise, tolerance, max_turn, memory, names, threads);
  return names;
}

void prepareCurvature(const BeamGrid& grid, const std::vector<LabelRun>& runs, CurvatureMemory& memory) {
  chooseSamples(grid, runs, memory.samples);
  cutAtRows(runs, grid.rows, grid.cols, memory.runs);
  findTouching(memory.runs, kMaxGap, memory.samples.regions.size(), memory.pairs, memory.touching);
}

void planarNames(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                 CurvatureMemory& memory, std::vector<std::int32_t>& names, int threads) {
  const std::vector<RegionSamples>& regions = memory.samples.regions;
  std::vector<Bend>& bends = memory.bends;
  bends.assign(regions.size(), Bend());
  forEachPart(threads, static_cast<int>(regions.size()), memory.beams,
              [&](int label, SampledBeams& beams) { sampleBend(grid, noise, label, beams, memory.samples, bends); });
  const auto& touching = memory.touching;
  const auto bent = [&](std::int32_t label) { return BentRegion{regions[label], bends[label]}; };
  std::vector<char>&curved = memory.curved, &weak = memory.weak;
  curved.assign(regions.size(), 0);
  weak.assign(regions.size(), 0);
  // Else an excess tells less than it seems to; in smooth noise, which makes bumps, little.
  const bool white = tolerance.isWhite(), bumpy = tolerance.isSmooth();
  for (std::size_t label = 1; label < regions.size(); ++label) {
    const Bend& bend = bends[label];
    const double excess = bend.excess / (kBendSignificance * tolerance.inflation);
    const auto bends_by = [&](double turn, double amplitude) {
      return bend.turn > turn * max_turn && bend.amplitude > amplitude * tolerance.sigma_distance;
    };
    const bool bends_weakly = (excess > (white ? kWeakExcess : 1.0) && bends_by(kWeakTurn, kWeakAmplitude)) ||
                              (white && excess > kClearExcess && bends_by(kWeakClearTurn, kWeakAmplitude));
    const bool bends_much =
        bends_by(1.0, kMinAmplitude) || (!bumpy && excess > kClearExcess && bends_by(kClearTurn, kClearAmplitude));
    weak[label] = bends_weakly ? 1 : 0;
    curved[label] = excess > 1.0 && bends_much ? 1 : 0;
  }
  std::vector<char>& alone = memory.alone;
  alone = curved;
  std::vector<char>& fans = memory.fans;
  fans.resize(touching.size());
  forEachPart(threads, static_cast<int>(touching.size()), [&](int k) {
    const auto& [a, b] = touching[k];
    fans[k] = (alone[a] & alone[b]) == 0 && isFan(bent(a), bent(b), tolerance, max_turn) ? 1 : 0;
  });
  for (std::size_t k = 0; k < touching.size(); ++k) {
    if (fans[k] != 0) curved[touching[k].first] = curved[touching[k].second] = 1;
  }
  // A strip that bends less, but beside a curved one of about its size, is more of the same surface.
  std::vector<char>& certain = memory.certain;
  certain = curved;
  for (const auto& [first, second] : touching) {
    if (certain[first] == certain[second]) continue;
    const bool of_first = certain[first] != 0;
    const std::int32_t strip = of_first ? second : first, beside = of_first ? first : second;
    if (regions[strip].points >= kStripSizes * regions[beside].points) continue;
    const bool is_more = (weak[strip] != 0 && mayTouch(regions[strip], regions[beside])) ||
                         isMoreOfFan(bent(strip), bent(beside), tolerance, max_turn);
    if (is_more) curved[strip] = 1;
  }
  // A bent strip along a larger plane that it hardly leaves is the soft edge of that plane.
  names.resize(regions.size());
  for (std::size_t label = 0; label < regions.size(); ++label) {
    names[label] = curved[label] != 0 ? 0 : static_cast<std::int32_t>(label);
  }
  std::vector<int>& host_points = memory.host_points;
  host_points.assign(regions.size(), 0);
  for (const auto& [a, b] : touching) {
    for (const auto& [strip, host] : {std::pair(a, b), std::pair(b, a)}) {
      if (alone[strip] == 0 || curved[host] != 0) continue;
      const RegionSamples& plane = regions[host];
      if (plane.points <= std::max(host_points[strip], kEdgeSizes * regions[strip].points)) continue;
      if (misfit(plane.plane, regions[strip]) > kEdgeTolerance * tolerance.sigma_distance) continue;
      host_points[strip] = plane.points;
      names[strip] = host;
    }
  }
}

}  // namespace ppc
