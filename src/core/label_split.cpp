// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_split.h"

#include "patch_plane_clustering/core/whole_tolerance.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr double kParallel = 0.998;  // least cosine
constexpr double kMinMisfit = 0.5;   // of both sides on one plane
constexpr double kNoise = 3.3;       // standard deviations of chi-square that noise alone may leave

}  // namespace

void LabelSplit::fit() {
  low.fit = fitPlane(low.sum);
  high.fit = fitPlane(high.sum);
}

int LabelSplit::smaller() const { return std::min(low.sum.n, high.sum.n); }

bool LabelSplit::areParallel() const { return low.fit.normal().dot(high.fit.normal()) >= kParallel; }

double LabelSplit::leftOver() const { return low.fit.chi2 + high.fit.chi2 - (low.sum.n + high.sum.n - 6.0); }

double LabelSplit::explained(const PlaneFit& whole) const { return whole.chi2 - low.fit.chi2 - high.fit.chi2; }

double LabelSplit::noise(const CoplanarityTolerance& tolerance) const {
  const double n = low.sum.n + high.sum.n;
  return kNoise * std::sqrt(2.0 * n * tolerance.inflationOf(n));
}

bool LabelSplit::isBeyond(const CoplanarityTolerance& tolerance, const NoiseModel& noise, const PlaneFit& whole) const {
  const Moments& small = low.sum.n < high.sum.n ? low.sum : high.sum;
  const double range = small.mean().norm(), sigma = noise.sigmaOf(small, range);
  return misfit(explained(whole), small.n / (sigma * sigma), std::min(small.radius(), kMaxWholeRadius),
                leastSecantSquared(whole, low.fit, high.fit, range), wholeTolerance(tolerance, sigma, small.n)) > kMinMisfit;
}

}  // namespace ppc
