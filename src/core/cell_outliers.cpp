// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_outliers.h"

#include "patch_plane_clustering/core/cell_residuals.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr float kMaxResidual = 36.0F;  // squared, of a point amid a region, where nothing else competes for it

}  // namespace

void CellOutliers::prefetch(const Patch& cell) const {
  const int middle = grid_.index((cell.row_begin + cell.row_end) / 2, cell.col_begin);
  __builtin_prefetch(grid_.range.data() + middle);
  if (grid_.origin_x.empty()) return;
  for (const std::vector<float>* numbers : {&grid_.origin_x, &grid_.origin_y, &grid_.origin_z}) {
    __builtin_prefetch(numbers->data() + middle);
  }
}

// From the sums of the cell alone, so that the pixels of most cells need not be read. With ranges r, m of the point and of
// the plane, an outlier adds (|a . p_0| r (r - m) / (m sigma))^2 to chi-square, where p_0 is on the plane and counted from
// the beam's start; if no range is below half the mean, that is least for r just short of the plane.
bool CellOutliers::mayHaveAny(const Patch& cell, std::int32_t label, int middle) const {
  constexpr double kMargin = 0.9;  // for rounding, and starts of beams that differ within the cell
  const Moments& m = cell.moments;
  const double range = cell.range, patch_sigma = noise_.sigma(range) * cell.noise_factor,
               weighed = patch_sigma * patch_sigma;
  const double spread = m.w * weighed - m.n * range * range;  // sum of squared differences from the mean range
  const double sigma = noise_.sigmaAt(middle, grid_.range[middle]), distance = tolerance_.forNoise(sigma).sigma_distance;
  const double limit2 = kMaxResidual * (sigma * sigma + distance * distance), range2 = range * range;
  if (!(spread < 0.25 * range2) || !(limit2 < 0.0625 * range2)) return true;
  double ahead = 1.0;
  if (!grid_.origin_x.empty()) ahead += planes_[label].dot(center_ - grid_.origin(middle).cast<double>());
  // The least is (ahead / (1 + 2 limit / range))^2 limit^2: multiplied out, as cells wait for divisions.
  const double stretched = range + 2.0 * std::sqrt(limit2), reached = ahead * range;
  return !(ahead > 0.5 &&
           chiSquare(m, planes_[label]) * weighed * (stretched * stretched) < kMargin * (reached * reached) * limit2);
}

bool CellOutliers::clear(const Patch& cell, std::int32_t label, LabelImage& out) const {
  const int middle = middlePixel(grid_, cell);
  if (!mayHaveAny(cell, label, middle)) return false;  // as in most cells
  const CellResiduals squared(CellNoise(grid_, noise_, tolerance_, middle), center_.cast<float>(),
                              planes_[label].cast<float>());
  const CellResiduals::Limit limit(squared, kMaxResidual);
  LaneMask suspected = {};
  const int rows = cell.row_end - cell.row_begin;
  for (int c = cell.col_begin; c < cell.col_end; c += kLanes) {
    int i = grid_.index(cell.row_begin, c);
    const int count = cell.col_end - c;
    for (int k = 0; k < rows; ++k, i += grid_.cols) {
      suspected |= limit.mayExceed(count >= kLanes ? BeamLanes(grid_, i) : BeamLanes(grid_, i, count));
    }
  }
  if (!anyLane(suspected)) return false;
  bool any = false;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int c = cell.col_begin; c < cell.col_end; c += kLanes) {
      const int i = grid_.index(r, c), count = std::min(kLanes, cell.col_end - c);
      const LaneMask outside = squared(BeamLanes(grid_, i, count)) > fill(kMaxResidual);
      for (int lane = 0; lane < count; ++lane) {
        if (outside[lane] == 0) continue;
        out.labels[i + lane] = 0;
        any = true;
      }
    }
  }
  return any;
}

}  // namespace ppc
