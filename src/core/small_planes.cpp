// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/small_planes.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

constexpr double kLeastNear = 0.5;     // of a region's points, that are near its plane
constexpr double kStray2 = 100.0;      // squared error of a stray, in variances
constexpr double kMostStrays = 0.05;   // of a region's points: of more, it is the plane that is wrong
constexpr double kLeastOfLabel = 0.5;  // of the points of a label, that are of a piece which may have a plane of its own

// Takes strays off a region. Returns whether there are any.
bool clearStrays(const std::vector<RegionPoint>& points, const NearFit& fit, const CoplanarityTolerance& tolerance,
                 LabelImage& labels) {
  const ToleratedScale scaleOf(fit, tolerance);
  const auto isStray = [&](const RegionPoint& point) {
    const double error2 = point.squaredError(fit.a);
    return error2 >= kStray2 && error2 >= kStray2 * scaleOf(point);
  };
  const auto strays = std::count_if(points.begin(), points.end(), isStray);
  if (strays == 0 || static_cast<double>(strays) > kMostStrays * static_cast<double>(points.size())) return false;
  for (const RegionPoint& point : points) {
    if (isStray(point)) labels.labels[point.pixel] = 0;
  }
  return true;
}

}  // namespace

bool refitSmallPlanes(const JudgedImage& image, const std::vector<LabelRun>& runs, const std::vector<std::int32_t>& whole,
                      SmallPlaneMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels, int threads) {
  SmallRegions& small = memory.small;
  small.list(runs, image.smallest);
  std::vector<int>& of_whole = memory.of_whole;
  of_whole.assign(static_cast<std::size_t>(*std::max_element(whole.begin(), whole.end())) + 1, 0);
  for (std::size_t piece = 0; piece < small.points.size(); ++piece) of_whole[whole[piece]] += small.points[piece];
  const PixelStretch* const stretches = small.stretches.data();
  const std::size_t count = small.regions.size();
  memory.strays.assign(count, 0);
  forEachPart(threads, static_cast<int>(count), memory.points, [&](int k, std::vector<RegionPoint>& points) {
    const SmallRegions::Region& region = small.regions[k];
    if (small.points[region.label] < kLeastOfLabel * of_whole[whole[region.label]]) return;
    const NearFit fit = fitNear(image, stretches + region.begin, stretches + region.end, points);
    if (fit.of == NearFit::Of::kFew || fit.of == NearFit::Of::kNone) return;
    if (fit.points < kLeastNear * static_cast<double>(points.size())) return;
    planes[region.label] = fit.a;
    memory.strays[k] = clearStrays(points, fit, image.tolerance, labels) ? 1 : 0;
  });
  return std::count(memory.strays.begin(), memory.strays.end(), 1) > 0;
}

}  // namespace ppc
