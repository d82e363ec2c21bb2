// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/small_planes.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>

namespace ppc {
namespace {

constexpr double kStray2 = 100.0;  // squared error of a point that is none of a region, in variances

// Takes strays off a region. Returns how many there are.
int clearStrays(const std::vector<RegionPoint>& points, const Eigen::Vector3d& a, LabelImage& labels) {
  int strays = 0;
  for (const RegionPoint& point : points) {
    if (point.squaredError(a) < kStray2) continue;
    labels.labels[point.pixel] = 0;
    ++strays;
  }
  return strays;
}

}  // namespace

bool refitSmallPlanes(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance, int smallest, const std::vector<LabelRun>& runs,
                      SmallPlaneMemory& memory, std::vector<Eigen::Vector3d>& planes, LabelImage& labels, int threads) {
  SmallRegions& small = memory.small;
  small.list(runs, smallest);
  const PixelStretch* const stretches = small.stretches.data();
  const std::size_t count = small.regions.size();
  memory.strays.assign(count, 0);
  forEachPart(threads, static_cast<int>(count), memory.points, [&](int k, std::vector<RegionPoint>& points) {
    const SmallRegions::Region& region = small.regions[k];
    const NearFit fit = fitNear(grid, center, noise, tolerance, stretches + region.begin, stretches + region.end, points);
    if (fit.of == NearFit::Of::kAll || fit.of == NearFit::Of::kNear) planes[region.label] = fit.a;
    if (fit.of == NearFit::Of::kNear) memory.strays[k] = clearStrays(points, fit.a, labels);
  });
  return std::any_of(memory.strays.begin(), memory.strays.end(), [](int strays) { return strays > 0; });
}

}  // namespace ppc
