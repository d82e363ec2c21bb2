// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_errors.h"

#include "patch_plane_clustering/core/line_differences.h"
#include "patch_plane_clustering/core/line_misfit.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ppc {
namespace {

constexpr int kMinLines = 16;
constexpr int kBeams = 160;      // of a line that are looked at
constexpr int kMinSamples = 30;  // of a line
constexpr int kGlance = 3;       // every so many lines tell whether the others need to be looked at
constexpr int kMaxGlances = 36;
// Most images have no such errors: fewer beams of these lines tell whether they may have. As they tell less surely, errors
// are suspected at a lower limit: half the significance of so few beams is still less than the whole of all.
constexpr int kFewBeams = 64;          // of a line
constexpr double kSuspicion = 0.5;     // of the limits
constexpr int kMinLinesSuspected = 8;  // less cannot tell
constexpr int kRounds = 3;             // of turning lines: each makes slopes better known
constexpr int kDriftLines = 8;         // to either side: slower changes of tilt are left alone
// Where tilts come in steps, only the lines beside a step are off against their neighbours, so many tell how much:
constexpr double kStepShare = 0.85;
constexpr double kStepQuantile = 1.44;      // of that many absolute values of a normal distribution
constexpr double kLeastShare = 0.35;        // of errors of range, over the noise of single ranges
constexpr double kLeastTurnShare = 0.5;     // of what errors of tilt make of ranges
constexpr double kLeastError = 0.001;       // [m]
constexpr double kSignificance = 4.0;       // over what noise alone makes of a misfit
constexpr double kOutlier = 5.0;            // lines off by more, in standard deviations, lie on a crease of the scene
constexpr double kLeastDeviation = 0.1;     // of a turn, over those that there are: slopes are known that well
constexpr int kReaches[] = {1, 4, 16, 40};  // lines to either side that tell of errors of range
constexpr double kBent = 0.15;              // of single beams' noise: what planes of the scene are bent from line to line
constexpr double kLeftOfErrors = 0.1;  // of errors of range when the found ones are taken out, as drift from line to line,
constexpr double kLeftOfNoise = 0.1;   // and of single beams' noise
constexpr double kMostLeft = 0.75;     // of what sloped beams are off, if turned lines are worth it
constexpr double kMostLeftByTurns = 0.95;  // if they are turned instead of being moved

// One of the errors that lines may have.
using Component = LineFit LineMisfit::*;
constexpr Component kRange = &LineMisfit::range;
constexpr Component kRangeAlone = &LineMisfit::range_alone;
constexpr Component kTurn = &LineMisfit::turn;

// Standard deviations over all lines, of one of the two errors [m or rad].
struct LineNoise {
  double error = 0.0;   // of the errors of lines
  double misfit = 0.0;  // of the misfits that they cause
  double uneven = 0.0;  // of true tilts off the middle between those of the lines beside
  bool significant = false;
};

// @param beams of the lines that were looked at. @param share of the limits from which errors are significant.
LineNoise measureNoise(Component component, LineErrorMemory& memory, int beams = kBeams, double share = 1.0) {
  std::vector<double>&sizes = memory.sizes, &spreads = memory.spreads, &deviations = memory.deviations;
  std::vector<double>&slopes = memory.slopes, &uneven = memory.uneven;
  for (std::vector<double>* numbers : {&sizes, &spreads, &deviations, &slopes, &uneven}) numbers->clear();
  for (const LineMisfit& m : memory.misfits) {
    if ((m.*component).samples * kBeams < kMinSamples * beams) continue;
    sizes.push_back(std::abs((m.*component).value));
    deviations.push_back((m.*component).deviation);
    spreads.push_back(m.spread);
    slopes.push_back(m.slope);
    uneven.push_back(std::abs(m.turn.value + m.between));
  }
  LineNoise noise;
  if (static_cast<int>(sizes.size()) < kMinLines / kGlance) return noise;
  const double spread = median(spreads), deviation = median(deviations);
  noise.misfit = component == kTurn ? quantile(sizes, kStepShare) / kStepQuantile : kMadToSigma * median(sizes);
  noise.uneven = std::max(deviation, kMadToSigma * median(uneven));
  // Half a neighbour's error on either side adds to a line's own: 1 + 1/4 + 1/4.
  noise.error = std::sqrt(std::max(0.0, noise.misfit * noise.misfit - deviation * deviation) / 1.5);
  const double shown = component == kTurn ? noise.error * median(slopes) : noise.error;  // in ranges
  const double least = std::max(kLeastError, (component == kTurn ? kLeastTurnShare : kLeastShare) * spread);
  noise.significant = shown > share * least && noise.misfit > share * kSignificance * deviation;
  return noise;
}

// Calls f(line, scratch) for one in `stride` lines that have others on both sides.
template <typename F>
void forEachSampled(const GridLines& lines, int stride, LineErrorMemory& memory, int threads, F&& f) {
  const auto some = [&](int begin, int end, LineMisfitMemory& scratch) {
    for (int n = begin; n < end; ++n) {
      const int k = sampledLine(n, stride);
      if (k > 0 && k + 1 < lines.count()) f(k, scratch);
    }
  };
  forEachRange(threads, (lines.count() + stride - 1) / stride, memory.of_thread, some);
}

// Of one in `stride` lines, and nothing of the others: memory.misfits.
void measureMisfits(const GridLines& lines, LineErrorKind kind, int stride, LineErrorMemory& memory, int threads,
                    int beams = kBeams) {
  memory.misfits.assign(static_cast<std::size_t>(lines.count()), LineMisfit());
  forEachSampled(lines, stride, memory, threads, [&](int k, LineMisfitMemory& scratch) {
    memory.misfits[k] = measureLineMisfit(lines, k, kind, beams, scratch);
  });
}

bool tells(const LineFit& fit, const LineNoise& noise) {
  return fit.samples >= kMinSamples && std::abs(fit.value) <= kOutlier * noise.misfit;
}

std::vector<double> solveErrors(const std::vector<LineMisfit>& misfits, Component component, const LineNoise& noise) {
  const int count = static_cast<int>(misfits.size());
  std::vector<LineDifference> differences;
  for (int k = 1; k + 1 < count; ++k) {
    const LineMisfit& m = misfits[k];
    const LineFit& fit = m.*component;
    // The motor runs evenly, more or less.
    if (component == kTurn) differences.push_back({k, m.before, m.after, -m.between, noise.uneven * noise.uneven});
    if (!tells(fit, noise)) continue;
    const double least = component == kTurn ? kLeastDeviation * noise.misfit : 0.0;
    differences.push_back({k, m.before, m.after, fit.value, fit.deviation * fit.deviation + least * least});
  }
  return solveDifferences(differences, count, noise.error, component == kTurn);
}

// Takes out the mean over the lines around.
std::vector<double> withoutDrift(const std::vector<double>& errors) {
  const int count = static_cast<int>(errors.size());
  std::vector<double> sums(errors.size() + 1, 0.0), quick(errors.size());
  std::partial_sum(errors.begin(), errors.end(), sums.begin() + 1);
  for (int k = 0; k < count; ++k) {
    const int reach = std::min({kDriftLines, k, count - 1 - k});  // even on both sides
    quick[k] = errors[k] - (sums[k + reach + 1] - sums[k - reach]) / (2 * reach + 1);
  }
  return quick;
}

// Adds to the misfits of corrected lines what the errors that were taken out had made of them.
void addBack(const LineErrors& taken, std::vector<LineMisfit>& misfits) {
  const auto made = [](const std::vector<double>& errors, const LineMisfit& m, std::size_t k) {
    return errors.empty() ? 0.0 : errors[k] - m.before * errors[k - 1] - m.after * errors[k + 1];
  };
  for (std::size_t k = 1; k + 1 < misfits.size(); ++k) {
    misfits[k].range.value += made(taken.range, misfits[k], k);
    const double turn = made(taken.turn, misfits[k], k);
    misfits[k].turn.value += turn;
    misfits[k].between -= turn;
  }
}

// @param out has the size of the grid.
void removeRangeErrors(const LineErrors& errors, const BeamGrid& grid, BeamGrid& out) {
  const GridLines lines(grid, errors.in_columns);
  for (int k = 0; k < lines.count(); ++k) {
    const auto range = static_cast<float>(errors.range.empty() ? 0.0 : errors.range[k]);
    for (int beam = 0; beam < lines.beams(); ++beam) {
      const int i = lines.pixel(k, beam);
      out.range[i] = grid.range[i] - range;
    }
  }
}

// Solves errors of range anew, from what lines tell of each other that are farther and farther apart: the better errors are
// known, the clearer it is which beams meet the same plane.
void solveWide(const BeamGrid& grid, const LineNoise& noise, LineErrors& errors, LineErrorMemory& memory, int threads) {
  std::vector<double>& spreads = memory.spreads;
  spreads.clear();
  for (const LineMisfit& m : memory.misfits) {
    if (m.range.samples >= kMinSamples) spreads.push_back(m.spread);
  }
  const double spread = std::max(kLeastError, median(spreads));
  errors.range_left = std::hypot(kLeftOfErrors * noise.error, kLeftOfNoise * spread);
  const int count = static_cast<int>(errors.range.size());
  std::vector<LineDifference> differences;
  removeLineErrors(errors, grid, memory.corrected);
  for (const int reach : kReaches) {
    if (2 * reach >= count) break;
    removeRangeErrors(errors, grid, memory.corrected);
    const GridLines lines(memory.corrected, errors.in_columns);
    memory.wide.assign(static_cast<std::size_t>(count), LineMisfit());
    const auto measure = [&](int begin, int end, WideMisfitMemory& scratch) {
      for (int k = reach + begin; k < reach + end; ++k) memory.wide[k] = measureWideMisfit(lines, k, reach, spread, scratch);
    };
    forEachRange(threads, count - 2 * reach, memory.wide_of_thread, measure);
    const double bent = kBent * spread * std::sqrt(static_cast<double>(reach));
    for (int k = reach; k + reach < count; ++k) {
      const LineMisfit &m = memory.wide[k], &narrow = memory.misfits[k];
      if (m.range.samples < kMinSamples) {  // gaps everywhere; what was known stays
        const LineFit& fit = narrow.range;
        if (reach == 1 && tells(fit, noise)) {
          differences.push_back({k, narrow.before, narrow.after, fit.value, fit.deviation * fit.deviation});
        }
        continue;
      }
      if (std::abs(m.range.value) > noise.error) continue;
      const double taken = errors.range[k] - m.before * errors.range[k - reach] - m.after * errors.range[k + reach];
      const double variance = m.range.deviation * m.range.deviation + bent * bent;
      differences.push_back({k, m.before, m.after, m.range.value + taken, variance, reach});
    }
    errors.range = solveDifferences(differences, count, noise.error, false);
  }
}

LineErrors errorsOf(const BeamGrid& grid, bool in_columns, LineErrorKind kind, LineErrorMemory& memory, int threads) {
  LineErrors errors;
  errors.in_columns = in_columns;
  BeamGrid& corrected = memory.corrected;
  LineNoise range_noise;
  for (int round = 0; round < (kind == LineErrorKind::kRange ? 1 : kRounds); ++round) {
    if (round > 0) removeLineErrors(errors, grid, corrected);
    measureMisfits(GridLines(round > 0 ? corrected : grid, in_columns), kind, 1, memory, threads);
    if (round > 0) addBack(errors, memory.misfits);
    if (kind != LineErrorKind::kTurn) {
      const LineNoise noise = measureNoise(kRange, memory);
      if (!noise.significant) break;
      errors.range = solveErrors(memory.misfits, kRange, noise);
      range_noise = noise;
    }
    if (kind != LineErrorKind::kRange) {
      const LineNoise noise = measureNoise(kTurn, memory);
      if (!noise.significant) break;
      errors.turn = withoutDrift(solveErrors(memory.misfits, kTurn, noise));
    }
  }
  const bool wanted = kind != LineErrorKind::kBoth || !errors.turn.empty();  // both, or nothing of use
  if (wanted && !errors.range.empty()) solveWide(grid, range_noise, errors, memory, threads);
  return errors;
}

// What sloped beams are off without these errors, in those lines where they are off most.
LineOff leftOf(const LineErrors& errors, const BeamGrid& grid, int stride, LineErrorMemory& memory, int threads) {
  if (!errors.empty()) removeLineErrors(errors, grid, memory.corrected);
  const GridLines lines(errors.empty() ? grid : memory.corrected, errors.in_columns);
  std::vector<LineOff>& of_lines = memory.off;
  of_lines.assign(static_cast<std::size_t>(lines.count()), LineOff());
  forEachSampled(lines, stride, memory, threads, [&](int k, LineMisfitMemory& scratch) {
    const LineMisfit misfit = measureLineMisfit(lines, k, LineErrorKind::kBoth, kBeams, scratch);
    if (misfit.turn.samples >= kMinSamples) of_lines[k] = offOf(lines, k, scratch);
  });
  const auto most = [&](double LineOff::*off) {
    std::vector<double>& left = memory.sizes;
    left.clear();
    for (const LineOff& of_line : of_lines) {
      if (of_line.*off >= 0.0) left.push_back(of_line.*off);
    }
    return left.empty() ? -1.0 : quantile(left, kStepShare);
  };
  return {most(&LineOff::by_slopes), most(&LineOff::as_stated)};
}

// Whether lines may have errors, at a first look. @param stride of the lines that are looked at otherwise.
bool maySuffer(const GridLines& lines, int stride, LineErrorMemory& memory, int threads) {
  if (lines.count() < kMinLinesSuspected * stride) return true;
  measureMisfits(lines, LineErrorKind::kBoth, stride, memory, threads, kFewBeams);
  // Fitted together, a turn may take much of what is an error of range.
  return measureNoise(kRangeAlone, memory, kFewBeams, kSuspicion).significant ||
         measureNoise(kTurn, memory, kFewBeams, kSuspicion).significant;
}

LineErrors estimateAlong(const BeamGrid& grid, bool in_columns, LineErrorMemory& memory, int threads) {
  const GridLines lines(grid, in_columns);
  LineErrors ranges;
  ranges.in_columns = in_columns;
  if (lines.count() < kMinLines) return ranges;
  const int stride = std::max(kGlance, lines.count() / kMaxGlances);
  if (!maySuffer(lines, stride, memory, threads)) return ranges;
  measureMisfits(lines, LineErrorKind::kRange, stride, memory, threads);
  if (measureNoise(kRange, memory).significant) {
    ranges = errorsOf(grid, in_columns, LineErrorKind::kRange, memory, threads);
  }
  measureMisfits(lines, LineErrorKind::kBoth, stride, memory, threads);
  if (!measureNoise(kTurn, memory).significant) return ranges;
  const LineErrorKind kind = measureNoise(kRange, memory).significant ? LineErrorKind::kBoth : LineErrorKind::kTurn;
  const LineErrors turns = errorsOf(grid, in_columns, kind, memory, threads);
  if (turns.turn.empty()) return ranges;
  const LineOff left = leftOf(turns, grid, stride, memory, threads), was = leftOf(ranges, grid, stride, memory, threads);
  const double most = kind == LineErrorKind::kTurn && !ranges.empty() ? kMostLeftByTurns : kMostLeft;
  const bool known = left.by_slopes >= 0.0, better = left.by_slopes < most * was.by_slopes;
  // Beside gaps between lines slopes are wrong: there it shows by the directions alone that nothing gets better.
  return known && better && left.as_stated < was.as_stated ? turns : ranges;
}

}  // namespace

LineErrors estimateLineErrors(const BeamGrid& grid, int threads) {
  LineErrorMemory memory;
  return estimateLineErrors(grid, memory, threads);
}

LineErrors estimateLineErrors(const BeamGrid& grid, LineErrorMemory& memory, int threads) {
  LineErrors errors = estimateAlong(grid, false, memory, threads);
  const bool rows_are_lines = grid.beams_exact;  // so range images are defined
  return errors.empty() && !rows_are_lines ? estimateAlong(grid, true, memory, threads) : errors;
}

void removeLineErrors(const LineErrors& errors, const BeamGrid& grid, BeamGrid& out) {
  out = grid;
  removeRangeErrors(errors, grid, out);
  if (errors.turn.empty()) return;
  const GridLines lines(grid, errors.in_columns);
  for (int k = 0; k < lines.count(); ++k) {
    const GridLines::Span span = lines.spanAround(k);
    if (!(span.angle > 0.0)) continue;
    const auto turn = static_cast<float>(errors.turn[k] / span.angle);
    for (int beam = 0; beam < lines.beams(); ++beam) {
      const int i = lines.pixel(k, beam);
      const Eigen::Vector3f direction = (grid.direction(i) + turn * lines.chord(span, beam)).normalized();
      out.dir_x[i] = direction.x();
      out.dir_y[i] = direction.y();
      out.dir_z[i] = direction.z();
    }
  }
}

}  // namespace ppc
