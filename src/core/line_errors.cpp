// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/line_errors.h"

#include "patch_plane_clustering/core/quantile.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc {
namespace {

constexpr int kMinLines = 16;
constexpr int kSamples = 160;  // beams of a line that are looked at
constexpr int kMinSamples = 30;
constexpr int kGlance = 3;  // every so many lines tell whether the others need to be looked at
constexpr double kMadToSigma = 1.4826;
constexpr double kMedianLoss = 1.2533;  // standard deviation of a median over that of a mean
constexpr double kLeastShare = 0.5;     // of line errors, over the noise of single ranges
constexpr double kLeastError = 0.001;   // [m]
constexpr double kSignificance = 4.0;   // over what medians of noise show
constexpr double kOutlier = 5.0;        // lines off by more, in standard deviations, lie on a crease of the scene

double angleBetween(const BeamGrid& grid, int row_a, int row_b, int col) {
  const Eigen::Vector3f a = grid.direction(grid.index(row_a, col)), b = grid.direction(grid.index(row_b, col));
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// What a line is off against the two beside it.
struct Misfit {
  double before = 0.5, after = 0.5;  // weights of the two
  double value = 0.0;                // median over its beams [m]
  double spread = 0.0;               // standard deviation of single beams [m]
  int samples = 0;
};

Misfit measureMisfit(const BeamGrid& grid, int row, std::vector<float>& scratch) {
  Misfit misfit;
  const double back = angleBetween(grid, row - 1, row, grid.cols / 2), on = angleBetween(grid, row, row + 1, grid.cols / 2);
  if (back + on > 0.0) {
    misfit.before = on / (back + on);
    misfit.after = back / (back + on);
  }
  const auto before = static_cast<float>(misfit.before), after = static_cast<float>(misfit.after);
  scratch.clear();
  const int stride = std::max(1, grid.cols / kSamples);
  for (int c = row % stride; c < grid.cols; c += stride) {
    const int i = grid.index(row, c);
    const int up = i - grid.cols, down = i + grid.cols;
    // The weighted sum of two unit vectors is a little shorter than the one between them.
    const float length =
        std::sqrt(before * before + after * after + 2.0F * before * after * grid.direction(up).dot(grid.direction(down)));
    const float predicted = length / (before / grid.range[up] + after / grid.range[down]);
    const float e = grid.range[i] - predicted;
    if (std::isfinite(e)) scratch.push_back(e);
  }
  misfit.samples = static_cast<int>(scratch.size());
  if (misfit.samples < kMinSamples) return misfit;
  misfit.value = median(scratch);
  for (float& e : scratch) e = std::abs(e - static_cast<float>(misfit.value));
  misfit.spread = kMadToSigma * median(scratch);
  return misfit;
}

// Standard deviations over all lines [m].
struct LineNoise {
  double error = 0.0;   // of the errors of lines
  double misfit = 0.0;  // of the misfits that they cause
  double median = 0.0;  // of what noise alone does to a misfit
  bool significant = false;
};

LineNoise measureLineNoise(const std::vector<Misfit>& misfits) {
  std::vector<float> sizes, spreads;
  for (const Misfit& m : misfits) {
    if (m.samples < kMinSamples) continue;
    sizes.push_back(static_cast<float>(std::abs(m.value)));
    spreads.push_back(static_cast<float>(m.spread));
  }
  LineNoise noise;
  if (static_cast<int>(sizes.size()) < kMinLines / kGlance) return noise;
  const double spread = median(spreads);
  noise.misfit = kMadToSigma * median(sizes);
  noise.median = kMedianLoss * spread / std::sqrt(static_cast<double>(kSamples));
  // Half a neighbour's error on either side adds to a line's own: 1 + 1/4 + 1/4.
  noise.error = std::sqrt(std::max(0.0, noise.misfit * noise.misfit - noise.median * noise.median) / 1.5);
  noise.significant =
      noise.error > std::max(kLeastError, kLeastShare * spread) && noise.misfit > kSignificance * noise.median;
  return noise;
}

}  // namespace

std::vector<float> estimateLineErrors(const BeamGrid& grid) {
  if (grid.rows < kMinLines) return {};
  std::vector<Misfit> misfits(static_cast<std::size_t>(grid.rows));
  std::vector<float> scratch;
  for (int r = 1; r + 1 < grid.rows; r += kGlance) misfits[r] = measureMisfit(grid, r, scratch);
  if (!measureLineNoise(misfits).significant) return {};
  for (int r = 1; r + 1 < grid.rows; ++r) {
    if (misfits[r].samples == 0) misfits[r] = measureMisfit(grid, r, scratch);
  }
  const LineNoise noise = measureLineNoise(misfits);

  // Least squares: what each misfit leaves unexplained is small, and so is each error by itself.
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(grid.rows);
  const double prior = 1.0 / std::max(1e-12, noise.error * noise.error);
  for (int r = 0; r < grid.rows; ++r) {
    entries.emplace_back(r, r, prior);
    const Misfit& m = misfits[r];
    if (m.samples < kMinSamples || std::abs(m.value) > kOutlier * noise.misfit) continue;
    const double deviation = std::max(noise.median, kMedianLoss * m.spread / std::sqrt(static_cast<double>(m.samples)));
    const double weight = 1.0 / std::max(1e-12, deviation * deviation);
    const int rows[3] = {r - 1, r, r + 1};
    const double factors[3] = {-m.before, 1.0, -m.after};
    for (int i = 0; i < 3; ++i) {
      right[rows[i]] += weight * factors[i] * m.value;
      for (int j = 0; j < 3; ++j) entries.emplace_back(rows[i], rows[j], weight * factors[i] * factors[j]);
    }
  }
  Eigen::SparseMatrix<double> normal(grid.rows, grid.rows);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd solved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  std::vector<float> errors(static_cast<std::size_t>(grid.rows));
  for (int r = 0; r < grid.rows; ++r) errors[r] = static_cast<float>(solved[r]);
  return errors;
}

}  // namespace ppc
