// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

constexpr float kCap = 9.0F;                // squared residual beyond which a point is an outlier: three sigma
constexpr float kMaxWindowCost = 5.0F;      // mean capped cost over the window that a plane may have
constexpr float kMaxOwnResidual = 12.0F;    // squared residual of the point itself
constexpr float kMaxInnerResidual = 36.0F;  // the same amid a region, where nothing else competes for it

// Squared residuals of the pixels of a cell against one plane, in units of their variance. The tolerance's share of the
// variance changes little over a cell: it is taken at one pixel.
class CellResiduals {
 public:
  CellResiduals(const BeamGrid& grid, const Eigen::Vector3f& center, const NoiseModel& noise,
                const CoplanarityTolerance& tolerance, int pixel, const Eigen::Vector3f& a)
      : a_x_(fill(a.x())), a_y_(fill(a.y())), a_z_(fill(a.z())), offset_(fill(1.0F + a.dot(center))) {
    const float range = grid.range[pixel];
    const float along = a.dot(grid.direction(pixel));
    const float sec2 = std::min(static_cast<float>(kMaxSecant2), a.squaredNorm() / (along * along));
    const auto sigma = static_cast<float>(noise.sigma(range));
    const auto floor = static_cast<float>(tolerance.forNoise(sigma).sigma_distance);
    const float variance = sigma * sigma + floor * floor * sec2;
    precision_ = fill(1.0F / variance);
    variance_ratio_ = variance / (sigma * sigma);
  }

  /// Infinite where nothing was measured, or the plane is not in front of the sensor.
  Lanes operator()(const BeamLanes& beam) const {
    const Lanes along = alongOf(beam);
    const Lanes model = acrossOf(beam) / along;
    const Lanes e = beam.range - model;
    const LaneMask ahead = beam.valid & (model > Lanes{});
    return ahead ? e * e * precision_ : fill(std::numeric_limits<float>::infinity());
  }

  /// @brief Tells quickly which pixels may have a squared residual above a limit: all that have, and those close to it.
  class Limit {
   public:
    Limit(const CellResiduals& residuals, float limit)
        : residuals_(residuals), square_(0.99F * limit / residuals.precision_) {}

    LaneMask mayExceed(const BeamLanes& beam) const {
      const Lanes along = residuals_.alongOf(beam), across = residuals_.acrossOf(beam);
      const Lanes e = beam.range * along - across;  // times the cosine, so that nothing needs to be divided
      const LaneMask within = (e * e <= square_ * along * along) & (across * along > Lanes{});
      return beam.valid & ~within;
    }

   private:
    const CellResiduals& residuals_;
    Lanes square_;
  };

  /// Logarithm of the variance over that of the noise alone: a lenient plane explains everything, but nothing well.
  float logVariance() const { return std::log(variance_ratio_); }

 private:
  Lanes alongOf(const BeamLanes& beam) const { return a_x_ * beam.dir_x + a_y_ * beam.dir_y + a_z_ * beam.dir_z; }
  Lanes acrossOf(const BeamLanes& beam) const {
    return offset_ - (a_x_ * beam.origin_x + a_y_ * beam.origin_y + a_z_ * beam.origin_z);
  }

  Lanes a_x_, a_y_, a_z_, offset_, precision_ = {};
  float variance_ratio_ = 1.0F;
};

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

// Finds the patches within two steps of a patch, itself included.
class Neighbourhood {
 public:
  explicit Neighbourhood(const PatchGrid& patches) : patches_(patches), reached_(patches.patches.size(), -1) {}

  const std::vector<int>& around(int index) {
    found_.clear();
    const auto take = [&](int i) {
      if (reached_[i] == index) return;
      reached_[i] = index;
      found_.push_back(i);
    };
    take(index);
    std::size_t begin = 0;
    for (int step = 0; step < 2; ++step) {
      const std::size_t end = found_.size();
      for (; begin < end; ++begin) patches_.forEachNeighbour(found_[begin], take);
    }
    return found_;
  }

  /// The labels of these patches, in their order.
  const std::vector<std::int32_t>& labels(int index, const CellShares& shares) {
    labels_.clear();
    for (const int j : around(index)) {
      for (int s = shares.begin[j]; s < shares.begin[j + 1]; ++s) {
        const std::int32_t label = shares.shares[s].label;
        if (std::find(labels_.begin(), labels_.end(), label) == labels_.end()) labels_.push_back(label);
      }
    }
    std::sort(labels_.begin(), labels_.end());
    return labels_;
  }

 private:
  const PatchGrid& patches_;
  std::vector<int> reached_;  // the last patch from which each was reached
  std::vector<int> found_;
  std::vector<std::int32_t> labels_;
};

void paint(const BeamGrid& grid, const Patch& patch, std::int32_t label, LabelImage& out) {
  const int first = grid.index(patch.row_begin, patch.col_begin), cols = patch.col_end - patch.col_begin;
  const int rows = patch.row_end - patch.row_begin, stride = grid.cols;
  const float* ranges = grid.range.data() + first;
  std::int32_t* labels = out.labels.data() + first;
  if (cols == kLanes) {  // the default
    for (int row = 0; row < rows; ++row, ranges += stride, labels += stride) {
      const LaneMask painted = (loadLanes<Lanes>(ranges) > Lanes{}) & fillMask(label);
      std::memcpy(labels, &painted, sizeof painted);
    }
    return;
  }
  for (int row = 0; row < rows; ++row, ranges += stride, labels += stride) {
    for (int c = 0; c < cols; ++c) labels[c] = ranges[c] > 0.0F ? label : 0;
  }
}

// Numbers of the pixels of a cell and its surroundings, one column to the left and right and `reach` rows up and down,
// and their sums over windows of three columns and 2 reach + 1 rows.
class CellWindow {
 public:
  /// Slots of a row: one before the cell's columns, the cell's, and room for whole lanes behind.
  void reset(int width, int rows) {
    blocks_ = (width + kLanes - 1) / kLanes;
    stride_ = blocks_ * kLanes + 2 * kLanes;
    rows_ = rows;
    const auto size = static_cast<std::size_t>(stride_ * rows);
    if (values_.size() < size) values_.resize(size);
    if (across_.size() < size / kLanes) across_.resize(size / kLanes);
  }

  /// Sets all numbers to 0.
  void clear() { std::fill(values_.begin(), values_.begin() + stride_ * rows_, 0.0F); }

  int blocks() const { return blocks_; }

  /// Slot of column `x` of the cell (-1: the one before it) in a row of the window.
  int slot(int row, int x) const { return stride_ * row + x + 1; }
  float* at(int slot) { return values_.data() + slot; }

  /// Calls f(k, sums) for the rows [begin, end) of the window and blocks of four columns of the cell, k in their order, row
  /// by row. Sums along the rows come first: each counts in several windows.
  template <typename F>
  void forEachSum(int begin, int end, int reach, F&& f) {
    const int blocks = blocks_, rows = rows_;  // not read again after each number that is written
    Lanes* const across = across_.data();
    const float* line = at(slot(0, -1));
    for (int row = 0, k = 0; row < rows; ++row, line += stride_) {
      const float* first = line;
      for (int b = 0; b < blocks; ++b, ++k, first += kLanes) {
        across[k] = loadLanes<Lanes>(first) + loadLanes<Lanes>(first + 1) + loadLanes<Lanes>(first + 2);
      }
    }
    for (int b = 0; b < blocks; ++b) {
      const auto at = [&](int row) { return across[row * blocks + b]; };
      Lanes sum = {};
      for (int row = std::max(0, begin - reach); row < std::min(rows, begin + reach); ++row) sum += at(row);
      for (int row = begin, k = b; row < end; ++row, k += blocks) {
        if (row + reach < rows) sum += at(row + reach);
        if (row > begin && row > reach) sum -= at(row - reach - 1);
        f(k, sum);
      }
    }
  }

 private:
  int blocks_ = 0, stride_ = 0, rows_ = 0;
  std::vector<float> values_;
  std::vector<Lanes> across_;  // sums over three columns
};

// Resolves the points of one patch among candidate clusters.
class PatchResolver {
 public:
  PatchResolver(const BeamGrid& grid, const PatchGrid& patches, const std::vector<Eigen::Vector3d>& planes,
                const NoiseModel& noise, const CoplanarityTolerance& tolerance)
      : grid_(grid),
        patches_(patches),
        planes_(planes),
        noise_(noise),
        tolerance_(tolerance),
        center_(patches.center.cast<float>()) {}

  /// Clears the pixels of a cell that its only label does not explain. @return whether there are any.
  bool clearOutliers(const Patch& cell, std::int32_t label, LabelImage& out) const {
    const CellResiduals squared = residuals(middlePixel(grid_, cell), label);
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
        const int i = grid_.index(r, c), count = cell.col_end - c;
        const BeamLanes beams = count >= kLanes ? BeamLanes(grid_, i) : BeamLanes(grid_, i, count);
        const LaneMask outside = squared(beams) > fill(kMaxInnerResidual);
        if (!anyLane(outside)) continue;
        for (int lane = 0; lane < std::min(kLanes, cell.col_end - c); ++lane) {
          if (outside[lane] == 0) continue;
          out.labels[grid_.index(r, c + lane)] = 0;
          any = true;
        }
      }
    }
    return any;
  }

  /// Gives every pixel of a cell the likeliest of the candidate labels, or 0.
  /// @param keep: pixels that no candidate explains keep their label instead.
  void resolve(const Patch& patch, const std::vector<std::int32_t>& candidates, std::int32_t first_open, bool keep,
               LabelImage& out) {
    const int middle = middlePixel(grid_, patch);
    if (middle < 0) return;
    const int strip = patch.col_begin / patches_.strip_cols;
    const int reach = std::max(1, patches_.strip_rows[strip] / patches_.strip_cols);
    countWindow(patch, reach);
    forEachBlock(patch, [&](int k, int i, int count) {
      const LaneMask labels =
          count == kLanes ? loadLanes<LaneMask>(&out.labels[i]) : loadLanes<LaneMask>(&out.labels[i], count);
      places_[k].open = ((labels <= LaneMask{}) | (labels >= fillMask(first_open))) & firstLanes(count);
      if (keep) places_[k].winner = labels;
    });
    for (const std::int32_t candidate : candidates) compete(patch, reach, middle, candidate);
    forEachBlock(patch, [&](int k, int i, int count) {
      for (int lane = 0; lane < count; ++lane) {
        if (places_[k].open[lane] != 0) out.labels[i + lane] = places_[k].winner[lane];
      }
    });
  }

 private:
  CellResiduals residuals(int pixel, std::int32_t label) const {
    return CellResiduals(grid_, center_, noise_, tolerance_, pixel, planes_[label].cast<float>());
  }

  // Calls f(k, i, count) for the blocks of up to four pixels of the cell, row by row: `count` pixels from i on.
  template <typename F>
  void forEachBlock(const Patch& patch, F&& f) const {
    for (int r = patch.row_begin, k = 0; r < patch.row_end; ++r) {
      for (int c = patch.col_begin; c < patch.col_end; c += kLanes) {
        f(k++, grid_.index(r, c), std::min(kLanes, patch.col_end - c));
      }
    }
  }

  // Beams of the window, and how many of them each pixel's own window counts.
  void countWindow(const Patch& patch, int reach) {
    const int top = std::max(0, patch.row_begin - reach), bottom = std::min(grid_.rows, patch.row_end + reach);
    const int left = std::max(0, patch.col_begin - 1), right = std::min(grid_.cols, patch.col_end + 1);
    const int width = patch.col_end - patch.col_begin;
    first_row_ = patch.row_begin - top;
    costs_.reset(width, bottom - top);
    own_.reset(width, bottom - top);
    if (left == patch.col_begin || right == patch.col_end) costs_.clear();  // else all that counts is written
    const int blocks = costs_.blocks();
    beams_.clear();
    beams_.reserve(static_cast<std::size_t>((bottom - top) * (blocks + 1)));
    for (int r = top; r < bottom; ++r) {
      for (int c = left; c < right; c += kLanes) {
        beams_.emplace_back(grid_, grid_.index(r, c), right - c, costs_.slot(r - top, c - patch.col_begin));
        storeLanes(beams_.back().beams.valid ? fill(1.0F) : Lanes{}, costs_.at(beams_.back().slot));
      }
    }
    places_.resize(static_cast<std::size_t>((patch.row_end - patch.row_begin) * blocks));
    Place* const places = places_.data();
    costs_.forEachSum(first_row_, first_row_ + patch.row_end - patch.row_begin, reach, [&](int k, Lanes count) {
      places[k].inverse_count = 1.0F / (count > fill(1.0F) ? count : fill(1.0F));
      places[k].best = fill(std::numeric_limits<float>::infinity());
      places[k].winner = LaneMask{};
    });
    for (int row = 0, k = 0; k < static_cast<int>(places_.size()); ++row) {
      for (int b = 0; b < blocks; ++b, ++k) places[k].slot = own_.slot(first_row_ + row, b * kLanes);
    }
  }

  void compete(const Patch& patch, int reach, int middle, std::int32_t candidate) {
    const CellResiduals squared = residuals(middle, candidate);
    float* const costs = costs_.at(0);
    float* const residuals_there = own_.at(0);
    for (const WindowBeams& window : beams_) {
      const Lanes own = squared(window.beams);
      storeLanes(own, residuals_there + window.slot);
      const Lanes capped = own < fill(kCap) ? own : fill(kCap);
      storeLanes(window.beams.valid ? capped : Lanes{}, costs + window.slot);
    }
    const auto ownOf = [&](const Place& place) { return loadLanes<Lanes>(residuals_there + place.slot); };
    LaneMask near = {};
    for (const Place& place : places_) near |= place.open & (ownOf(place) <= fill(kMaxOwnResidual));
    if (!anyLane(near)) return;  // it can win no pixel whose label may change
    const float log_variance = squared.logVariance();
    Place* const places = places_.data();
    costs_.forEachSum(first_row_, first_row_ + patch.row_end - patch.row_begin, reach, [&](int k, Lanes sum) {
      Place& place = places[k];
      const Lanes mean = sum * place.inverse_count;
      const Lanes total = mean + log_variance;
      const LaneMask better = (ownOf(place) <= fill(kMaxOwnResidual)) & (mean < fill(kMaxWindowCost)) & (total < place.best);
      place.best = better ? total : place.best;
      place.winner = better ? fillMask(candidate) : place.winner;
    });
  }

  struct WindowBeams {
    WindowBeams(const BeamGrid& grid, int i, int count, int window_slot)
        : beams(count >= kLanes ? BeamLanes(grid, i) : BeamLanes(grid, i, count)), slot(window_slot) {}

    BeamLanes beams;
    int slot;
  };

  // Four pixels of the cell.
  struct Place {
    Lanes inverse_count, best;
    LaneMask winner, open;  // open: the label may change
    int slot;
  };

  const BeamGrid& grid_;
  const PatchGrid& patches_;
  const std::vector<Eigen::Vector3d>& planes_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  Eigen::Vector3f center_;
  std::vector<WindowBeams> beams_;
  CellWindow costs_, own_;
  int first_row_ = 0;  // of the cell in its window
  std::vector<Place> places_;
};

}  // namespace

void patchLabels(const BeamGrid& grid, const PatchGrid& patches, const CellShares& shares, LabelImage& out, int threads) {
  out.rows = grid.rows;
  out.cols = grid.cols;
  out.labels.resize(static_cast<std::size_t>(grid.size()));
  forEachRange(threads, static_cast<int>(patches.patches.size()), [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      const bool labelled = shares.begin[p] < shares.begin[p + 1];
      paint(grid, patches.patches[p], labelled ? shares.shares[shares.begin[p]].label : 0, out);
    }
  });
}

void refineLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                  const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                  std::int32_t first_open, LabelImage& labels, std::vector<char>& changed, int threads) {
  changed.assign(cells.patches.size(), 0);
  const int count = static_cast<int>(cells.patches.size());

  // The label of cells that have just one, whole; 0 of all others.
  std::vector<std::int32_t> whole(cells.patches.size(), 0);
  std::vector<bool> open(cells.patches.size(), false);
  for (int k = 0; k < count; ++k) {
    int labelled = 0;
    for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
      labelled += shares.shares[s].moments.n;
      open[k] = open[k] || shares.shares[s].label >= first_open;
    }
    const bool full = labelled == cells.patches[k].moments.n;
    if (full && shares.begin[k + 1] - shares.begin[k] == 1) whole[k] = shares.shares[shares.begin[k]].label;
    open[k] = open[k] || !full;
  }
  forEachRange(threads, count, [&](int begin, int end) {
    PatchResolver resolver(grid, cells, planes, noise, tolerance);
    Neighbourhood neighbourhood(cells);
    for (int k = begin; k < end; ++k) {
      const Patch& cell = cells.patches[k];
      if (cell.moments.n == 0 || !open[k]) continue;
      const std::int32_t own = whole[k];
      bool inside = own > 0;
      cells.forEachNeighbour(k, [&](int j) { inside = inside && (whole[j] == own || cells.patches[j].moments.n == 0); });
      if (inside) {
        if (resolver.clearOutliers(cell, own, labels)) changed[k] = 1;
        continue;
      }
      resolver.resolve(cell, neighbourhood.labels(k, shares), first_open, false, labels);
      changed[k] = 1;
    }
  });
}

void contestLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, LabelImage& labels, int threads) {
  const std::vector<int> border = borderCells(cells, shares);
  forEachRange(threads, static_cast<int>(border.size()), [&](int begin, int end) {
    PatchResolver resolver(grid, cells, planes, noise, tolerance);
    Neighbourhood neighbourhood(cells);
    for (int k = begin; k < end; ++k) {
      resolver.resolve(cells.patches[border[k]], neighbourhood.labels(border[k], shares), 1, true, labels);
    }
  });
}

}  // namespace ppc
