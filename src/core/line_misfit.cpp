// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_misfit.h"

#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/core/weighted_median.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ppc {
namespace {

constexpr int kRounds = 3;                // of fitting one error given the other
constexpr int kBeamsThatMove = 16;        // of which the one is taken that moves most
constexpr float kLeastMotion = 0.1F;      // of a beam, over that of the beam that moves most
constexpr double kClearSlope = 3.0;       // over its own noise: a smaller one would explain noise by turns without end
constexpr float kMaxRelativeBend = 0.5F;  // of the surface over the lines that a slope is taken from, over the slope,
constexpr float kMaxFlatBend = 0.02F;     // or over the range

// Change of range for each radian of tilt; NaN where the lines around do not lie on one surface.
float slopeAt(const GridLines& lines, int line, int beam, const GridLines::Span& span) {
  const auto inverseRange = [&](int k) { return 1.0F / lines.grid().range[lines.pixel(k, beam)]; };
  const float first = inverseRange(span.before), here = inverseRange(line), last = inverseRange(span.after);
  const auto share = static_cast<float>(line - span.before) / static_cast<float>(span.after - span.before);
  const float difference = last - first, bend = std::abs(first + share * difference - here);
  const bool one_surface = bend < kMaxRelativeBend * std::abs(difference) || bend < kMaxFlatBend * here;
  if (!one_surface) return std::numeric_limits<float>::quiet_NaN();
  return -difference / (here * here * static_cast<float>(span.angle));
}

float betweenAt(const GridLines& lines, int line, int beam, const GridLines::Span& span) {
  const Eigen::Vector3f chord = lines.chord(span, beam);
  const auto angle = static_cast<float>(span.angle);
  if (!(chord.norm() > kLeastMotion * angle)) return 0.0F;  // near the axis
  const Eigen::Vector3f middle = 0.5F * (lines.direction(line - 1, beam) + lines.direction(line + 1, beam));
  return angle * chord.dot(lines.direction(line, beam) - middle) / chord.squaredNorm();
}

// Median of a number of each sample. @param scratch overwritten.
template <typename Number>
double medianOf(const std::vector<LineSample>& samples, std::vector<float>& scratch, Number&& number) {
  scratch.clear();
  for (const LineSample& s : samples) scratch.push_back(number(s));
  return median(scratch);
}

// Noise of single beams about a fit.
double spreadOf(const std::vector<LineSample>& samples, double range, double turn, std::vector<float>& scratch) {
  return kMadToSigma * medianOf(samples, scratch, [&](const LineSample& s) {
           return std::abs(s.error - static_cast<float>(range + turn * s.slope));
         });
}

double fitRange(const std::vector<LineSample>& samples, double turn, std::vector<float>& scratch) {
  return medianOf(samples, scratch, [&](const LineSample& s) { return s.error - static_cast<float>(turn) * s.slope; });
}

// The turn that makes the sum of the absolute errors least: a median of quotients, weighted with the slopes.
double fitTurn(const std::vector<LineSample>& samples, double range, std::vector<std::pair<float, float>>& scratch) {
  scratch.clear();
  for (const LineSample& s : samples) {
    const float weight = std::abs(s.slope);
    if (weight > 0.0F) scratch.emplace_back((s.error - static_cast<float>(range)) / s.slope, weight);
  }
  return weightedMedian(scratch);
}

// @param spread of single beams [m].
void clearNoisySlopes(double angle, double spread, std::vector<LineSample>& samples) {
  const auto least = static_cast<float>(kClearSlope * std::sqrt(2.0) * spread / angle);
  for (LineSample& s : samples) {
    if (std::abs(s.slope) < least) s.slope = 0.0F;
  }
}

// Range less what a plane through the beams beside it predicts. @param misfit the weights of the two.
float errorAt(const GridLines& lines, int line, int beam, const LineMisfit& misfit) {
  const BeamGrid& grid = lines.grid();
  const auto before = static_cast<float>(misfit.before), after = static_cast<float>(misfit.after);
  const int i = lines.pixel(line, beam), back = i - lines.lineStep(), on = i + lines.lineStep();
  // The weighted sum of two unit vectors is a little shorter than the one between them.
  const float length =
      std::sqrt(before * before + after * after + 2.0F * before * after * grid.direction(back).dot(grid.direction(on)));
  return grid.range[i] - length / (before / grid.range[back] + after / grid.range[on]);
}

void sampleLine(const GridLines& lines, int line, const GridLines::Span& span, bool turns, int beams,
                const LineMisfit& misfit, std::vector<LineSample>& samples) {
  samples.clear();
  const int stride = std::max(1, lines.beams() / beams);
  for (int beam = line % stride; beam < lines.beams(); beam += stride) {
    const float error = errorAt(lines, line, beam, misfit);
    const float slope = turns ? slopeAt(lines, line, beam, span) : 0.0F;
    if (!std::isfinite(error) || !std::isfinite(slope)) continue;
    samples.push_back({error, slope, turns ? betweenAt(lines, line, beam, span) : 0.0F, beam});
  }
}

}  // namespace

void weighNeighbours(const GridLines& lines, int line, int reach, LineMisfit& misfit) {
  const auto angle = [&](int k, int beam) {
    const Eigen::Vector3f a = lines.direction(k, beam), b = lines.direction(k + reach, beam);
    return static_cast<double>(std::atan2(a.cross(b).norm(), a.dot(b)));
  };
  const auto valid = [&](int k, int beam) { return lines.grid().valid(lines.pixel(k, beam)); };
  double most = 0.0;  // beams near the axis tell nothing; nor do, in clouds, those without a point
  for (int beam = 0; beam < lines.beams(); beam += std::max(1, lines.beams() / kBeamsThatMove)) {
    if (!valid(line - reach, beam) || !valid(line, beam) || !valid(line + reach, beam)) continue;
    const double back = angle(line - reach, beam), on = angle(line, beam);
    if (!(back + on > most)) continue;
    most = back + on;
    misfit.before = on / most;
    misfit.after = back / most;
  }
}

LineMisfit measureLineMisfit(const GridLines& lines, int line, LineErrorKind kind, int beams, LineMisfitMemory& memory) {
  std::vector<LineSample>& samples = memory.samples;
  std::vector<float>& scratch = memory.numbers;
  const bool turns = kind != LineErrorKind::kRange, ranges = kind != LineErrorKind::kTurn;
  LineMisfit misfit;
  const GridLines::Span span = lines.spanAround(line);
  if (turns && !(span.angle > 0.0)) return misfit;
  if (!turns) weighNeighbours(lines, line, 1, misfit);  // else the fit itself tells where the line lies between the two
  sampleLine(lines, line, span, turns, beams, misfit, samples);
  misfit.range.samples = static_cast<int>(samples.size());
  if (samples.empty()) return misfit;

  const auto deviationOf = [](double spread) { return std::max(1e-6, kMedianLoss * spread); };  // of single beams
  if (turns) {
    const double alone = fitRange(samples, 0.0, scratch), spread = spreadOf(samples, alone, 0.0, scratch);
    misfit.range_alone = {alone, deviationOf(spread) / std::sqrt(static_cast<double>(samples.size())), misfit.range.samples};
    clearNoisySlopes(span.angle, spread, samples);
  }
  double range = 0.0, turn = 0.0;  // the turn against the middle between the two
  for (int round = 0; round < (turns && ranges ? kRounds : 1); ++round) {
    const double before = range;
    if (turns) turn = fitTurn(samples, range, memory.turns);
    if (ranges) range = fitRange(samples, turn, scratch);
    if (range == before) break;  // another round would find the same
  }
  misfit.spread = spreadOf(samples, range, turn, scratch);
  if (turns) misfit.between = medianOf(samples, scratch, [](const LineSample& s) { return s.between; });
  misfit.range.value = range;
  misfit.turn.value = turn - misfit.between;

  // Sums of the normal equations of range and turn.
  double ones = 0.0, sums = 0.0, squares = 0.0;
  std::vector<float>& slopes = memory.slopes;
  slopes.clear();
  for (const LineSample& s : samples) {
    ones += 1.0;
    if (s.slope == 0.0F) continue;
    sums += s.slope;
    squares += static_cast<double>(s.slope) * s.slope;
    slopes.push_back(std::abs(s.slope));
  }
  const double shared = turns && ranges ? sums * sums : 0.0;
  const double deviation = deviationOf(misfit.spread);
  const auto of = [&](double sum, double other) {
    const double information = sum - (shared > 0.0 ? shared / other : 0.0);
    return information > 0.0 ? deviation / std::sqrt(information) : std::numeric_limits<double>::infinity();
  };
  misfit.range.deviation = of(ones, squares);
  misfit.turn.deviation = of(squares, ones);
  misfit.turn.samples = static_cast<int>(slopes.size());
  if (!slopes.empty()) misfit.slope = median(slopes);
  return misfit;
}

LineOff offOf(const GridLines& lines, int line, LineMisfitMemory& memory) {
  LineMisfit stated;
  weighNeighbours(lines, line, 1, stated);
  const auto middle = [&](auto&& off_of) {
    std::vector<float>& off = memory.numbers;
    off.clear();
    for (const LineSample& s : memory.samples) {
      if (s.slope != 0.0F) off.push_back(std::abs(off_of(s)));
    }
    return off.empty() ? -1.0 : median(off);
  };
  return {middle([](const LineSample& s) { return s.error - s.slope * s.between; }),
          middle([&](const LineSample& s) { return errorAt(lines, line, s.beam, stated); })};
}

}  // namespace ppc
