// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_grid.h"

#include "patch_plane_clustering/core/block_moments.h"

#include <cmath>
#include <cstdint>

namespace ppc {
namespace {

// A patch near the pole may be this many times higher than wide in pixels: beyond, the lines no longer part.
constexpr int kMaxAspect = 16;
constexpr double kAspect = 1.3;

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double angleBetween(const BeamGrid& grid, int a, int b) { return (grid.direction(a) - grid.direction(b)).norm(); }

// Median angle between horizontal neighbours, over a sample of the image.
double columnStep(const BeamGrid& grid) {
  std::vector<double> steps;
  const int stride = std::max(1, grid.rows / 32);
  for (int r = 0; r < grid.rows; r += stride) {
    for (int c = 0; c + 1 < grid.cols; c += 7) {
      const int i = grid.index(r, c);
      if (grid.beams_exact || (grid.valid(i) && grid.valid(i + 1))) steps.push_back(angleBetween(grid, i, i + 1));
    }
  }
  return median(steps);
}

// Median angle between vertical neighbours in one column.
double rowStep(const BeamGrid& grid, int col) {
  std::vector<double> steps;
  const int stride = std::max(1, grid.rows / 64);
  for (int r = 0; r + 1 < grid.rows; r += stride) {
    const int i = grid.index(r, col);
    const int below = grid.index(r + 1, col);
    if (grid.beams_exact || (grid.valid(i) && grid.valid(below))) steps.push_back(angleBetween(grid, i, below));
  }
  return median(steps);
}

Eigen::Vector3d sensorCenter(const BeamGrid& grid) {
  if (grid.origin_x.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int r = 0; r < grid.rows; ++r) sum += grid.origin(grid.index(r, grid.cols / 2)).cast<double>();
  return sum / grid.rows;
}

void linkNeighbours(PatchGrid& grid) {
  grid.neighbour_begin.reserve(grid.patches.size() + 1);
  grid.neighbours.reserve(6 * grid.patches.size());
  const auto link = [&grid](int block) {
    if (grid.patch_of_block[block] >= 0) grid.neighbours.push_back(grid.patch_of_block[block]);
  };
  for (int strip = 0; strip < grid.strips(); ++strip) {
    for (int block = grid.strip_begin[strip]; block < grid.strip_begin[strip + 1]; ++block) {
      const int index = grid.patch_of_block[block];
      if (index < 0) continue;
      grid.neighbour_begin.push_back(static_cast<int>(grid.neighbours.size()));
      const Patch& patch = grid.patches[index];
      if (patch.moments.n == 0) continue;  // nothing is ever asked from there
      if (block > grid.strip_begin[strip]) link(block - 1);
      if (block + 1 < grid.strip_begin[strip + 1]) link(block + 1);
      for (const int side : {strip - 1, strip + 1}) {
        if (side < 0 || side >= grid.strips()) continue;
        const int first = grid.strip_begin[side] + patch.row_begin / grid.strip_rows[side];
        const int last = grid.strip_begin[side] + (patch.row_end - 1) / grid.strip_rows[side];
        for (int i = first; i <= last; ++i) link(i);
      }
    }
  }
  grid.neighbour_begin.push_back(static_cast<int>(grid.neighbours.size()));
}

}  // namespace

PatchGrid makePatchGrid(const BeamGrid& grid, int patch_size, bool equal_angle, const LabelImage* done) {
  PatchGrid out;
  out.rows = grid.rows;
  out.cols = grid.cols;
  out.strip_cols = patch_size;
  out.center = sensorCenter(grid);
  const int strips = (grid.cols + patch_size - 1) / patch_size;
  const double column_step = columnStep(grid);
  const auto sum = [&](const Patch& patch, auto&& choose) {
    return sumBlock(grid, out.center, patch.row_begin, patch.row_end, patch.col_begin, patch.col_end, choose);
  };
  const auto open = [&](int i, int count) {
    const std::int32_t* labels = done->labels.data() + i;
    return (i + kLanes <= grid.size() ? loadLanes<LaneMask>(labels) : loadLanes<LaneMask>(labels, count)) <= LaneMask{};
  };
  out.strip_begin.push_back(0);
  for (int s = 0; s < strips; ++s) {
    int height = patch_size;
    if (equal_angle) {
      const double row_step = rowStep(grid, std::min(s * patch_size + patch_size / 2, grid.cols - 1));
      // Also without any step to go by (one row, no valid pair) the patch stays square.
      const double ratio = row_step > 0.0 && column_step > 0.0 ? column_step / row_step : 1.0;
      height = static_cast<int>(std::lround(std::min(kAspect * ratio, double{kMaxAspect}) * patch_size));
    }
    out.strip_rows.push_back(std::clamp(height, 2, std::max(2, grid.rows)));
    for (int r = 0; r < grid.rows; r += out.strip_rows.back()) {
      Patch patch;
      patch.row_begin = r;
      patch.row_end = std::min(r + out.strip_rows.back(), grid.rows);
      patch.col_begin = s * patch_size;
      patch.col_end = std::min(patch.col_begin + patch_size, grid.cols);
      const BlockMoments sums = done == nullptr ? sum(patch, [](int, int) { return fillMask(-1); }) : sum(patch, open);
      patch.moments = sums.moments;
      patch.range = sums.meanRange();
      if (patch.moments.n > 0) patch.fit = fitPlane(patch.moments);
      const bool kept = done == nullptr || patch.moments.n > 0;
      out.patch_of_block.push_back(kept ? static_cast<int>(out.patches.size()) : -1);
      if (kept) out.patches.push_back(patch);
    }
    out.strip_begin.push_back(static_cast<int>(out.patch_of_block.size()));
  }
  linkNeighbours(out);
  return out;
}

}  // namespace ppc
