// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/wide_misfit.h"

#include "patch_plane_clustering/core/quantile.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {
namespace {

constexpr int kAlong = 4;             // beams to either side that tell the change of range along a line
constexpr int kBeams = 500;           // of a line that are looked at, about
constexpr int kSectors = 16;          // of a line, at most
constexpr int kMinSectors = 4;        // that tell
constexpr int kSectorBeams = 16;      // at least
constexpr int kMinBeams = 4;          // of a sector that tells
constexpr double kFarthest = 3.0;     // error of a beam on a plane, over the spread
constexpr float kLeastMotion = 0.3F;  // of a beam from line to line, over that of the beam that moves most
constexpr float kMostMotion = 0.6F;   // of that one [rad]: farther apart few beams meet the same plane

// A line between two others.
class WideLine {
 public:
  WideLine(const GridLines& lines, int line, int reach) : lines_(lines), line_(line), step_(reach * lines.lineStep()) {
    const int stride = std::max(1, lines.beams() / kSectors);
    for (int beam = 0; beam < lines.beams(); beam += stride) {
      const int i = lines.pixel(line, beam);
      if (lines.grid().valid(i - step_) && lines.grid().valid(i + step_)) motion_ = std::max(motion_, motionOf(beam));
    }
  }

  float motion() const { return motion_; }

  // Range less the predicted one [m]; NaN near the axis, and where ranges are missing. @param beam kAlong from either end.
  float errorOf(int beam) const {
    if (!(motionOf(beam) > kLeastMotion * motion_)) return std::numeric_limits<float>::quiet_NaN();
    const BeamGrid& grid = lines_.grid();
    const int i = lines_.pixel(line_, beam);
    const int left = lines_.pixel(line_, beam - kAlong), right = lines_.pixel(line_, beam + kAlong);
    // Inverse range is linear in the direction.
    Eigen::Matrix3f beams;
    beams << grid.direction(i - step_), grid.direction(i + step_), grid.direction(right) - grid.direction(left);
    const Eigen::Vector3f shares = beams.inverse() * grid.direction(i);
    const float inverse = shares[0] / grid.range[i - step_] + shares[1] / grid.range[i + step_] +
                          shares[2] * (1.0F / grid.range[right] - 1.0F / grid.range[left]);
    return grid.range[i] - 1.0F / inverse;
  }

 private:
  float motionOf(int beam) const {
    const int i = lines_.pixel(line_, beam);
    return (lines_.grid().direction(i + step_) - lines_.grid().direction(i - step_)).norm();
  }

  const GridLines& lines_;
  int line_, step_;
  float motion_ = 0.0F;
};

}  // namespace

LineMisfit measureWideMisfit(const GridLines& lines, int line, int reach, double spread, WideMisfitMemory& memory) {
  const WideLine wide(lines, line, reach);
  if (!(wide.motion() < kMostMotion)) return {};
  LineMisfit misfit;
  weighNeighbours(lines, line, reach, misfit);
  LineFit& fit = misfit.range;
  std::vector<float>&errors = memory.errors, &sectors = memory.sectors;
  sectors.clear();
  const auto farthest = static_cast<float>(kFarthest * spread);
  const int stride = std::max(1, lines.beams() / kBeams);
  const int width = std::max(kSectorBeams, (lines.beams() + kSectors - 1) / kSectors);
  for (int sector = 0; sector * width < lines.beams(); ++sector) {
    const int begin = std::max(kAlong, sector * width), end = std::min(lines.beams() - kAlong, (sector + 1) * width);
    errors.clear();
    for (int beam = begin; beam < end; beam += stride) {
      const float error = wide.errorOf(beam);
      if (std::abs(error) < farthest) errors.push_back(error);
    }
    if (static_cast<int>(errors.size()) < kMinBeams) continue;
    sectors.push_back(static_cast<float>(median(errors)));
    fit.samples += static_cast<int>(errors.size());
  }
  if (static_cast<int>(sectors.size()) < kMinSectors) return {};
  fit.value = median(sectors);
  for (float& value : sectors) value = std::abs(value - static_cast<float>(fit.value));
  const double apart = kMadToSigma * median(sectors) / std::sqrt(static_cast<double>(sectors.size()));
  fit.deviation = kMedianLoss * std::max(spread / std::sqrt(static_cast<double>(fit.samples)), apart);
  return misfit;
}

}  // namespace ppc
