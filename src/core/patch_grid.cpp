// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_grid.h"

#include "patch_plane_clustering/core/block_moments.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/parallel.h"

#include <cmath>
#include <cstdint>

namespace ppc {
namespace {

// A patch near the pole may be this many times higher than wide in pixels: beyond, the lines no longer part.
constexpr int kMaxAspect = 16;
constexpr double kAspect = 1.3;
constexpr int kStepCols = 8;  // columns between those where the step from row to row is measured
// Rows whose patches are stored together: what lies together in the image is then also read together.
constexpr int kBandRows = 32;

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
  const int stride = std::max(1, grid.rows / 32);
  for (int r = 0; r + 1 < grid.rows; r += stride) {
    const int i = grid.index(r, col);
    const int below = grid.index(r + 1, col);
    if (grid.beams_exact || (grid.valid(i) && grid.valid(below))) steps.push_back(angleBetween(grid, i, below));
  }
  return median(steps);
}

// Steps between the rows at columns kStepCols apart, 0 where there is none to go by.
std::vector<double> rowSteps(const BeamGrid& grid) {
  std::vector<double> steps;
  for (int c = 0; c < grid.cols + kStepCols - 1; c += kStepCols) steps.push_back(rowStep(grid, std::min(c, grid.cols - 1)));
  return steps;
}

double interpolate(const std::vector<double>& steps, int col) {
  const auto k = static_cast<std::size_t>(col / kStepCols);
  if (k + 1 >= steps.size()) return steps.back();
  if (!(steps[k] > 0.0) || !(steps[k + 1] > 0.0)) return std::max(steps[k], steps[k + 1]);
  const double share = static_cast<double>(col % kStepCols) / kStepCols;
  return (1.0 - share) * steps[k] + share * steps[k + 1];
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
  for (const Patch& patch : grid.patches) {
    grid.neighbour_begin.push_back(static_cast<int>(grid.neighbours.size()));
    if (patch.moments.n == 0) continue;  // nothing is ever asked from there
    const int strip = patch.col_begin / grid.strip_cols;
    const int block = grid.strip_begin[strip] + patch.row_begin / grid.strip_rows[strip];
    if (block > grid.strip_begin[strip]) link(block - 1);
    if (block + 1 < grid.strip_begin[strip + 1]) link(block + 1);
    for (const int side : {strip - 1, strip + 1}) {
      if (side < 0 || side >= grid.strips()) continue;
      const int first = grid.strip_begin[side] + patch.row_begin / grid.strip_rows[side];
      const int last = grid.strip_begin[side] + (patch.row_end - 1) / grid.strip_rows[side];
      for (int i = first; i <= last; ++i) link(i);
    }
  }
  grid.neighbour_begin.push_back(static_cast<int>(grid.neighbours.size()));
}

}  // namespace

PatchGrid makePatchGrid(const BeamGrid& grid, int patch_size, bool equal_angle, const LabelImage* done, int threads) {
  PatchGrid out;
  out.rows = grid.rows;
  out.cols = grid.cols;
  out.strip_cols = patch_size;
  out.center = sensorCenter(grid);
  const int strips = (grid.cols + patch_size - 1) / patch_size;
  const double column_step = equal_angle ? columnStep(grid) : 0.0;
  const std::vector<double> row_steps = equal_angle ? rowSteps(grid) : std::vector<double>();
  const auto sum = [&](const Patch& patch, auto&& choose) {
    return sumBlock(grid, out.center, patch.row_begin, patch.row_end, patch.col_begin, patch.col_end, choose);
  };
  const auto open = [&](int i, int count) { return labelsAt(*done, i, count) <= LaneMask{}; };
  out.strip_begin.push_back(0);
  for (int s = 0; s < strips; ++s) {
    int height = patch_size;
    if (equal_angle) {
      const double row_step = interpolate(row_steps, std::min(s * patch_size + patch_size / 2, grid.cols - 1));
      // Also without any step to go by (one row, no valid pair) the patch stays square.
      const double ratio = row_step > 0.0 && column_step > 0.0 ? column_step / row_step : 1.0;
      height = static_cast<int>(std::lround(std::min(kAspect * ratio, double{kMaxAspect}) * patch_size));
    }
    height = std::clamp(height, 2, std::max(2, grid.rows));
    out.strip_rows.push_back(height);
    out.strip_begin.push_back(out.strip_begin.back() + (grid.rows + height - 1) / height);
  }
  out.patch_of_block.assign(static_cast<std::size_t>(out.strip_begin.back()), -1);
  const int bands = (grid.rows + kBandRows - 1) / kBandRows;
  std::vector<std::vector<Patch>> found(static_cast<std::size_t>(bands));
  forEachPart(threads, bands, [&](int band) {
    const int band_begin = band * kBandRows, band_end = std::min(band_begin + kBandRows, grid.rows);
    std::size_t blocks = 0;
    for (const int height : out.strip_rows) blocks += (band_end - 1) / height + 1 - (band_begin + height - 1) / height;
    if (done == nullptr) found[band].reserve(blocks);
    for (int s = 0; s < strips; ++s) {
      const int height = out.strip_rows[s];
      for (int k = (band_begin + height - 1) / height; k * height < band_end; ++k) {
        Patch patch;
        patch.row_begin = k * height;
        patch.row_end = std::min(patch.row_begin + height, grid.rows);
        patch.col_begin = s * patch_size;
        patch.col_end = std::min(patch.col_begin + patch_size, grid.cols);
        const BlockMoments sums = done == nullptr ? sum(patch, [](int, int) { return fillMask(-1); }) : sum(patch, open);
        if (done != nullptr && sums.moments.n == 0) continue;
        patch.moments = sums.moments;
        patch.range = sums.meanRange();
        if (patch.moments.n > 0) patch.fit = fitPlane(patch.moments);
        found[band].push_back(patch);
      }
    }
  });
  std::size_t count = 0;
  for (const auto& patches : found) count += patches.size();
  out.patches.reserve(count);
  for (const auto& patches : found) {
    for (const Patch& patch : patches) {
      const int strip = patch.col_begin / patch_size;
      out.patch_of_block[out.strip_begin[strip] + patch.row_begin / out.strip_rows[strip]] =
          static_cast<int>(out.patches.size());
      out.patches.push_back(patch);
    }
  }
  linkNeighbours(out);
  return out;
}

}  // namespace ppc
