// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_start.h"

#include "patch_plane_clustering/core/across_fit.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace ppc {
namespace {

constexpr int kSample = 512;    // points
constexpr int kSampleRun = 16;  // neighbours among them
constexpr int kRuns = kSample / kSampleRun;
constexpr int kMaxSteps = 8;
constexpr int kMaxTrimmedSteps = 4;             // if the sample is the region; one, if there are points to come
constexpr double kSettled = 0.2;                // gain of a step, in variances of the errors
constexpr int kFewest = 64;                     // points, for errors to have a distribution
constexpr int kDifferenceStep = 3;              // pixels: they share no neighbours then
constexpr std::size_t kFewestDifferences = 12;  // of neighbours, for noise to have one
// Errors across the beams, of their angles, lever arm and spot [m]: as large as the noise, within these limits.
constexpr double kLeastAcross = 0.00075, kAcross = 0.0025;
constexpr double kMaxSoftness = 100.0;  // which is total least squares
constexpr double kTrim = 2.5;           // standard deviations
constexpr double kRounding = 1e-5;      // of the range, in single precision
constexpr double kEdgeOn = 30.0;        // times as far off the plane along the beams as off that across
constexpr double kExact = 1e-4;         // of the range: errors that do not matter

// Where run k begins among so many pixels: somewhere in its part of them, another place from part to part, for if rows are
// as long as each other, runs at even distances may all lie in the same columns.
long long runBegin(long long pixels, int k) {
  constexpr std::uint32_t kGolden = 2654435769U;  // over 2^32: the golden ratio's fraction, whose multiples spread evenly
  const long long first = pixels * k / kRuns, last = pixels * (k + 1) / kRuns;
  const auto share = static_cast<std::uint32_t>(k) * kGolden;
  return first + static_cast<long long>((static_cast<std::uint64_t>(last - first) * share) >> 32U);
}

// Fills the sample: all of the region, or runs of it, which go on in the next block if one is too short. @return which.
bool takeSample(const PixelStretch* begin, const PixelStretch* end, std::vector<PixelStretch>& sample) {
  long long pixels = 0;
  for (const PixelStretch* block = begin; block != end; ++block) pixels += block->end - block->begin;
  if (pixels <= kSample) {
    sample.assign(begin, end);
    return true;
  }
  sample.clear();
  long long before = 0;
  int run = 0, left = 0;  // the next one; pixels that are still to be taken for the last one
  for (const PixelStretch* block = begin; block != end; ++block) {
    const int length = block->end - block->begin;
    for (int at = 0; at < length;) {
      if (left == 0) {
        if (run == kRuns || runBegin(pixels, run) >= before + length) break;
        at = std::max(at, static_cast<int>(runBegin(pixels, run) - before));
        left = kSampleRun;
        ++run;
      }
      const int taken = std::min(left, length - at);
      sample.push_back({block->begin + at, block->begin + at + taken});
      at += taken;
      left -= taken;
    }
    before += length;
  }
  return false;
}

// One standard deviation of the errors, as sumBeams() weighs them, told from the median of every other four [m].
double errorOf(const BeamGrid& grid, const std::vector<PixelStretch>& blocks, const Plane& plane, double softness,
               std::vector<float>& squares) {
  const Lanes nx = fill(static_cast<float>(plane.normal.x())), ny = fill(static_cast<float>(plane.normal.y())),
              nz = fill(static_cast<float>(plane.normal.z())), d = fill(static_cast<float>(plane.d)),
              soft = fill(static_cast<float>(softness)), whole = fill(static_cast<float>(1.0 + softness));
  squares.clear();
  for (const PixelStretch& block : blocks) {
    for (int i = block.begin; i < block.end; i += 2 * kLanes) {
      const BeamLanes beam(grid, i, block.end - i);
      const Lanes cosine = nx * beam.dir_x + ny * beam.dir_y + nz * beam.dir_z;
      const Lanes h = nx * beam.origin_x + ny * beam.origin_y + nz * beam.origin_z - d + beam.range * cosine;
      const Lanes square = whole * h * h / (cosine * cosine + soft);
      for (int k = 0; k < kLanes; ++k) {
        if (beam.valid[k] != 0) squares.push_back(square[k]);
      }
    }
  }
  return squares.empty() ? 0.0 : kMadToSigma * std::sqrt(static_cast<double>(median(squares)));
}

// One standard deviation of the noise of the ranges, told from the second differences of neighbours in a row [m].
std::optional<double> noiseOf(const BeamGrid& grid, const std::vector<PixelStretch>& blocks,
                              std::vector<float>& differences) {
  differences.clear();
  for (const PixelStretch& block : blocks) {
    for (int i = block.begin + 1; i + 1 < block.end; i += kDifferenceStep) {
      if (!grid.valid(i - 1) || !grid.valid(i) || !grid.valid(i + 1)) continue;
      differences.push_back(std::abs(grid.range[i - 1] - 2.0F * grid.range[i] + grid.range[i + 1]));
    }
  }
  if (differences.size() < kFewestDifferences) return std::nullopt;
  return kMadToSigma * static_cast<double>(median(differences)) / std::sqrt(6.0);
}

// Fits the sample of a region.
class Starter {
 public:
  Starter(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, BeamStartMemory& memory)
      : grid_(grid), sample_(memory.sample), values_(memory.values), is_region_(takeSample(begin, end, memory.sample)) {}

  BeamStart find() {
    for (const PixelStretch& block : sample_) {  // runs are far apart: all are fetched at a time
      prefetchBeams(grid_, block.begin);
      prefetchBeams(grid_, block.end - 1);
    }
    const int first = firstValid(grid_, sample_.data(), sample_.data() + sample_.size());
    if (first < 0) return start_;
    PointSums points;
    const Eigen::Vector3d about = grid_.point(first).cast<double>();
    start_.origin = grid_.origin(first).cast<double>();
    for (const PixelStretch& block : sample_) addPoints(grid_, block.begin, block.end, about, points);
    if (points.n < 3) return start_;
    const PlanarRegion across = fitAcross(0, about, points);
    centroid_ = across.centroid;
    towards_ = Eigen::Vector3d(-points.ux, -points.uy, -points.uz).normalized();
    const double distance = (centroid_ - start_.origin).norm();

    if (!moveTo({towards_, towards_.dot(centroid_)})) return start_;
    const std::optional<BeamStep> step = stepOf(sum(BeamWeights::kInverse));
    if (!step || !moveTo(movedBy(*step, start_.frame, start_.origin))) return start_;
    if (!settle(BeamWeights::kNear, kMaxSteps)) return start_;
    if (rms_ > kEdgeOn * across.rms && rms_ > kExact * distance) return start_;
    start_.scale.limit = kNoLimit;
    start_.along = points.n < kFewest || soften();
    if (start_.along && points.n >= kFewest) trim(kRounding * distance);
    return start_;
  }

 private:
  BeamSums sum(BeamWeights weights) const {
    return sumBeams(grid_, sample_.data(), sample_.data() + sample_.size(), start_.frame, weights, start_.scale);
  }

  double error() const { return errorOf(grid_, sample_, start_.frame.plane(), start_.scale.softness, values_); }

  bool moveTo(const Plane& plane) {
    if (!plane.normal.allFinite() || !std::isfinite(plane.d) || !(plane.normal.dot(towards_) > 0.0)) return false;
    start_.frame = BeamFrame(plane, centroid_);
    return true;
  }

  bool settle(BeamWeights weights, int steps) {
    for (int k = 0; k < steps; ++k) {
      const BeamSums sums = sum(weights);
      const std::optional<BeamStep> step =
          stepOf(sums, weights == BeamWeights::kTrimmed ? newtonScale(sums, start_.scale.limit) : 1.0);
      if (!step || sums.kept < std::max(4, sums.valid / 2)) return false;
      if (!moveTo(movedBy(*step, start_.frame, start_.origin))) return false;
      rms_ = std::sqrt(sums.hh / sums.valid);
      if (step->gain * sums.kept <= kSettled * sums.whh) break;
    }
    return true;
  }

  // Errors across the beams, beside the noise along them. What neighbours share does not show in their differences, and
  // what is across the beams shows in the errors as well: noise is between the two.
  bool soften() {
    const BeamSums sums = sum(BeamWeights::kNear);
    const double error_along = std::sqrt(sums.whh / std::max(1, sums.kept));
    const double noise = std::sqrt(error_along * noiseOf(grid_, sample_, values_).value_or(error_along));
    const double across = std::clamp(noise, kLeastAcross, kAcross);
    start_.scale.softness = std::min(kMaxSoftness, across * across / (noise * noise));
    return settle(BeamWeights::kNear, kMaxSteps);
  }

  void trim(double rounding) {
    const BeamStart before = start_;
    start_.scale.limit = kTrim * error() + rounding;
    if (!settle(BeamWeights::kTrimmed, is_region_ ? kMaxTrimmedSteps : 1)) start_ = before;
  }

  const BeamGrid& grid_;
  const std::vector<PixelStretch>& sample_;
  std::vector<float>& values_;
  bool is_region_;  // all of it
  BeamStart start_;
  Eigen::Vector3d centroid_, towards_;
  double rms_ = 0.0;  // across the plane before the last step
};

}  // namespace

BeamStart startOf(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, BeamStartMemory& memory) {
  return Starter(grid, begin, end, memory).find();
}

}  // namespace ppc
