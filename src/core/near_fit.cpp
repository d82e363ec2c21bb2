// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/near_fit.h"

#include "patch_plane_clustering/core/moments.h"

namespace ppc {
namespace {

constexpr int kFits = 3;  // the first one of all points, then of those that are near
constexpr int kFewestPoints = 4;

}  // namespace

void sumNear(const JudgedImage& image, const std::vector<LabelRun>& runs, const std::vector<char>& wanted,
             const std::vector<Eigen::Vector3d>& planes, std::vector<Moments>& sums) {
  sums.assign(planes.size(), Moments());
  for (const LabelRun& run : runs) {
    if (wanted[run.label] == 0) continue;
    for (int i = run.begin; i < run.end; ++i) {
      const RegionPoint point = regionPointAt(image, i);
      if (isNear(point, planes[run.label])) addPoint(point, sums[run.label]);
    }
  }
}

NearFit fitNear(const JudgedImage& image, const PixelStretch* begin, const PixelStretch* end,
                std::vector<RegionPoint>& points) {
  const BeamGrid& grid = image.grid;
  points.clear();
  double variances = 0.0, noises = 0.0;
  for (const PixelStretch* stretch = begin; stretch != end; ++stretch) {
    for (int i = stretch->begin; i < stretch->end; ++i) {
      if (!grid.valid(i)) continue;
      const double sigma = image.noise.sigmaAt(i, grid.range[i]);
      const double variance = varianceOf(image, sigma);
      points.push_back(regionPointAt(image, i, variance));
      variances += variance;
      noises += sigma * sigma;
    }
  }
  NearFit fit;
  const double count = std::max<double>(1.0, static_cast<double>(points.size()));
  fit.sigma = std::sqrt(variances / count);
  fit.noise = std::sqrt(noises / count);
  for (int k = 0; k < kFits; ++k) {
    Moments sum;
    for (const RegionPoint& point : points) {
      if (k > 0 && !(point.squaredError(fit.a) < RegionPoint::kFarthest2)) continue;
      addPoint(point, sum);
    }
    fit.points = sum.n;
    if (sum.n < kFewestPoints) {
      fit.of = k == 0 ? NearFit::Of::kFew : NearFit::Of::kNone;
      return fit;
    }
    const PlaneFit plane = fitPlane(sum);
    fit.a = plane.a;
    fit.of = k == 0 ? NearFit::Of::kAll : NearFit::Of::kNear;
    fit.radius = sum.radius();
    if (k == 0 && plane.chi2 <= mostChiSquare(sum.n)) return fit;
  }
  return fit;
}

}  // namespace ppc
