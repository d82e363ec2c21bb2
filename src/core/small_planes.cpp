// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/small_planes.h"

#include "patch_plane_clustering/core/parallel.h"

namespace ppc {

void refitSmallPlanes(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance, int smallest, const std::vector<LabelRun>& runs,
                      SmallPlaneMemory& memory, std::vector<Eigen::Vector3d>& planes, int threads) {
  SmallRegions& small = memory.small;
  small.list(runs, smallest);
  const PixelStretch* const stretches = small.stretches.data();
  const auto count = static_cast<int>(small.regions.size());
  forEachPart(threads, count, memory.points, [&](int k, std::vector<RegionPoint>& points) {
    const SmallRegions::Region& region = small.regions[k];
    const NearFit fit = fitNear(grid, center, noise, tolerance, stretches + region.begin, stretches + region.end, points);
    if (fit.of == NearFit::Of::kAll || fit.of == NearFit::Of::kNear) planes[region.label] = fit.a;
  });
}

}  // namespace ppc
