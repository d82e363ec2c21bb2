// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_resolver.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

constexpr float kCap = 9.0F;                // squared residual beyond which a point is an outlier: three sigma
constexpr float kMaxWindowCost = 5.0F;      // mean capped cost over the window that a plane may have
constexpr float kMaxOwnResidual = 12.0F;    // squared residual of the point itself
constexpr float kMaxInnerResidual = 36.0F;  // the same amid a region, where nothing else competes for it

// The valid pixel nearest to the middle of a cell, in scan order; -1 if there is none.
int middlePixel(const BeamGrid& grid, const Patch& cell) {
  const int width = cell.col_end - cell.col_begin, size = width * (cell.row_end - cell.row_begin);
  const auto pixel = [&](int k) { return grid.index(cell.row_begin + k / width, cell.col_begin + k % width); };
  for (int step = 0; step <= size / 2; ++step) {
    if (size / 2 + step < size && grid.valid(pixel(size / 2 + step))) return pixel(size / 2 + step);
    if (grid.valid(pixel(size / 2 - step))) return pixel(size / 2 - step);
  }
  return -1;
}

Lanes capped(Lanes squared, LaneMask valid) {
  const Lanes cost = squared < fill(kCap) ? squared : fill(kCap);
  return valid ? cost : Lanes{};
}

}  // namespace

CellResolver::CellResolver(const BeamGrid& grid, const PatchGrid& cells, const std::vector<Eigen::Vector3d>& planes,
                           const NoiseModel& noise, const CoplanarityTolerance& tolerance)
    : grid_(grid),
      cells_(cells),
      planes_(planes),
      noise_(noise),
      tolerance_(tolerance),
      center_(cells.center.cast<float>()) {}

CellResiduals CellResolver::residuals(const CellNoise& noise, std::int32_t label) const {
  return CellResiduals(noise, center_, planes_[label].cast<float>());
}

bool CellResolver::clearOutliers(const Patch& cell, std::int32_t label, LabelImage& out) const {
  const CellResiduals squared = residuals(noiseOf(middlePixel(grid_, cell)), label);
  const CellResiduals::Limit limit(squared, kMaxInnerResidual);
  LaneMask suspected = {};
  const int rows = cell.row_end - cell.row_begin;
  for (int c = cell.col_begin; c < cell.col_end; c += kLanes) {
    int i = grid_.index(cell.row_begin, c);
    const int count = cell.col_end - c;
    for (int k = 0; k < rows; ++k, i += grid_.cols) {
      suspected |= limit.mayExceed(count >= kLanes ? BeamLanes(grid_, i) : BeamLanes(grid_, i, count));
    }
  }
  if (!anyLane(suspected)) return false;  // as in most cells
  bool any = false;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int c = cell.col_begin; c < cell.col_end; c += kLanes) {
      const int i = grid_.index(r, c), count = std::min(kLanes, cell.col_end - c);
      const LaneMask outside = squared(BeamLanes(grid_, i, count)) > fill(kMaxInnerResidual);
      for (int lane = 0; lane < count; ++lane) {
        if (outside[lane] == 0) continue;
        out.labels[i + lane] = 0;
        any = true;
      }
    }
  }
  return any;
}

void CellResolver::resolve(const Patch& cell, const std::vector<std::int32_t>& candidates, std::int32_t first_open,
                           bool keep, LabelImage& out) {
  const int pixel = middlePixel(grid_, cell);
  if (pixel < 0) return;
  const CellNoise noise = noiseOf(pixel);
  const int reach = std::max(1, cells_.strip_rows[cell.col_begin / cells_.strip_cols] / cells_.strip_cols);
  for (int col = cell.col_begin; col < cell.col_end; col += kLanes) {
    readWindow(cell, col, reach);
    openPlaces(cell, col, first_open, keep, out);
    for (const std::int32_t candidate : candidates) compete(noise, reach, candidate);
    paint(cell, col, out);
  }
}

// Sums costs of the middle, cost(row), and of the sides over three columns.
template <typename Cost>
void CellResolver::sumAcross(const Cost& cost) {
  const float* side = side_costs_.data();
  for (int row = 0; row < rows_; ++row, side += 2) {
    const Lanes middle = cost(row);
    const Lanes before = __builtin_shufflevector(middle, Lanes{side[0]}, 4, 0, 1, 2);
    const Lanes after = __builtin_shufflevector(middle, Lanes{side[1]}, 1, 2, 3, 4);
    across_[row] = before + middle + after;
  }
}

// Calls f(row of the cell, sums over each pixel's own window).
template <typename F>
void CellResolver::forEachSum(int reach, const F& f) const {
  Lanes sum = {};
  for (int row = std::max(0, first_ - reach); row < std::min(rows_, first_ + reach); ++row) sum += across_[row];
  for (int row = first_; row < last_; ++row) {
    if (row + reach < rows_) sum += across_[row + reach];
    if (row > first_ && row > reach) sum -= across_[row - reach - 1];
    f(row - first_, sum);
  }
}

// Reads the beams of the window, and counts those in each pixel's own.
void CellResolver::readWindow(const Patch& cell, int col, int reach) {
  const int top = std::max(0, cell.row_begin - reach), bottom = std::min(grid_.rows, cell.row_end + reach);
  rows_ = bottom - top;
  first_ = cell.row_begin - top;
  last_ = cell.row_end - top;
  // A cell that ends amid the lanes has the column right of it in the next of them.
  const int width = cell.col_end - col, lanes = std::min(width + 1, grid_.cols - col);
  const bool left = col > 0, right = width >= kLanes && col + kLanes < grid_.cols;
  middle_.clear();
  for (int r = top; r < bottom; ++r) {
    const int i = grid_.index(r, col);
    if (lanes >= kLanes) {
      middle_.emplace_back(grid_, i);
    } else {
      middle_.emplace_back(grid_, i, lanes);
    }
  }
  sides_.clear();
  for (int r = top; r < bottom; r += 2) {
    const int i = grid_.index(r, col), below = r + 1 < bottom ? i + grid_.cols : i;
    const int pixels[kLanes] = {left ? i - 1 : i, right ? i + kLanes : i, left ? below - 1 : below,
                                right ? below + kLanes : below};
    sides_.emplace_back(grid_, pixels, LaneMask{left ? -1 : 0, right ? -1 : 0, left ? -1 : 0, right ? -1 : 0});
  }
  const auto rows = static_cast<std::size_t>(rows_);
  own_.resize(rows);
  across_.resize(rows);
  side_costs_.resize(sides_.size() * kLanes);
  places_.resize(static_cast<std::size_t>(last_ - first_));
  const auto one = [](LaneMask valid) { return valid ? fill(1.0F) : Lanes{}; };
  for (std::size_t k = 0; k < sides_.size(); ++k) storeLanes(one(sides_[k].valid), &side_costs_[k * kLanes]);
  sumAcross([&](int row) { return one(middle_[row].valid); });
  forEachSum(reach,
             [&](int row, Lanes count) { places_[row].inverse_count = 1.0F / (count > fill(1.0F) ? count : fill(1.0F)); });
}

void CellResolver::openPlaces(const Patch& cell, int col, std::int32_t first_open, bool keep, const LabelImage& labels) {
  const int count = std::min(kLanes, cell.col_end - col);
  int i = grid_.index(cell.row_begin, col);
  for (Place& place : places_) {
    const LaneMask now =
        count == kLanes ? loadLanes<LaneMask>(&labels.labels[i]) : loadLanes<LaneMask>(&labels.labels[i], count);
    place.open = ((now <= LaneMask{}) | (now >= fillMask(first_open))) & firstLanes(count);
    place.winner = keep ? now : LaneMask{};
    place.best = fill(std::numeric_limits<float>::infinity());
    i += grid_.cols;
  }
}

void CellResolver::compete(const CellNoise& noise, int reach, std::int32_t candidate) {
  const CellResiduals squared = residuals(noise, candidate);
  LaneMask near = {};
  for (int row = first_; row < last_; ++row) {
    const Lanes own = squared(middle_[row]);
    own_[row] = own;
    near |= places_[row - first_].open & (own <= fill(kMaxOwnResidual));
  }
  if (!anyLane(near)) return;  // it can win no pixel whose label may change
  for (int row = 0; row < first_; ++row) own_[row] = squared(middle_[row]);
  for (int row = last_; row < rows_; ++row) own_[row] = squared(middle_[row]);
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    storeLanes(capped(squared(sides_[k]), sides_[k].valid), &side_costs_[k * kLanes]);
  }
  sumAcross([&](int row) { return capped(own_[row], middle_[row].valid); });
  const float log_variance = squared.logVariance();
  forEachSum(reach, [&](int row, Lanes sum) {
    Place& place = places_[row];
    const Lanes mean = sum * place.inverse_count;
    const Lanes total = mean + log_variance;
    const LaneMask better =
        (own_[first_ + row] <= fill(kMaxOwnResidual)) & (mean < fill(kMaxWindowCost)) & (total < place.best);
    place.best = better ? total : place.best;
    place.winner = better ? fillMask(candidate) : place.winner;
  });
}

void CellResolver::paint(const Patch& cell, int col, LabelImage& out) const {
  const int count = std::min(kLanes, cell.col_end - col);
  int i = grid_.index(cell.row_begin, col);
  for (const Place& place : places_) {
    std::int32_t* const labels = &out.labels[i];
    if (count == kLanes) {
      const LaneMask painted = place.open ? place.winner : loadLanes<LaneMask>(labels);
      std::memcpy(labels, &painted, sizeof painted);
    } else {
      for (int lane = 0; lane < count; ++lane) labels[lane] = place.open[lane] != 0 ? place.winner[lane] : labels[lane];
    }
    i += grid_.cols;
  }
}

}  // namespace ppc
