// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_grid.h"

#include "patch_plane_clustering/core/block_moments.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/parallel.h"
#include "patch_plane_clustering/core/patch_links.h"
#include "patch_plane_clustering/core/patch_order.h"
#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/core/row_prefetch.h"

#include <cmath>
#include <cstdint>
#include <numeric>

namespace ppc {
namespace {

// A patch near the pole may be this many times higher than wide in pixels: beyond, the lines no longer part.
constexpr int kMaxAspect = 16;
constexpr double kAspect = 1.3;
constexpr int kStepCols = 8;      // columns between those where the step from row to row is measured
constexpr int kStepRows = 6;      // over which it is, if the rows come in steps
constexpr double kInSteps = 0.4;  // then it differs from that of neighbours by such a share
constexpr int kFetchAhead = 12;   // patches

double angleBetween(const BeamGrid& grid, int a, int b) { return (grid.direction(a) - grid.direction(b)).norm(); }

// Median angle between horizontal neighbours, over a sample of the image. @param steps scratch, overwritten.
double columnStep(const BeamGrid& grid, std::vector<double>& steps) {
  steps.clear();
  const int stride = std::max(1, grid.rows / 32);
  for (int r = 0; r < grid.rows; r += stride) {
    for (int c = 0; c + 1 < grid.cols; c += 7) {
      const int i = grid.index(r, c);
      if (grid.beams_exact || (grid.valid(i) && grid.valid(i + 1))) steps.push_back(angleBetween(grid, i, i + 1));
    }
  }
  return steps.empty() ? 0.0 : median(steps);
}

// Median angle from row to row in one column, over so many rows.
double rowStepOver(const BeamGrid& grid, int col, int span, std::vector<double>& steps) {
  steps.clear();
  const int stride = std::max(1, grid.rows / 32);
  for (int r = 0; r + span < grid.rows; r += stride) {
    const int i = grid.index(r, col), below = grid.index(r + span, col);
    if (grid.beams_exact || (grid.valid(i) && grid.valid(below))) steps.push_back(angleBetween(grid, i, below) / span);
  }
  return steps.empty() ? 0.0 : median(steps);
}

// That of neighbours, but for motors that go in steps of some rows: most of these are no angle apart, or more than others.
double rowStep(const BeamGrid& grid, int col, std::vector<double>& steps) {
  const double next = rowStepOver(grid, col, 1, steps), over = rowStepOver(grid, col, kStepRows, steps);
  return over > 0.0 && std::abs(next - over) > kInSteps * over ? over : next;
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

// Cuts the columns into strips, and each strip into blocks.
void layOut(const BeamGrid& grid, int patch_size, const AngularSteps& steps, PatchGrid& out) {
  out.strip_rows.clear();
  out.strip_begin.assign(1, 0);
  for (int col = 0; col < grid.cols; col += patch_size) {
    int height = patch_size;
    if (!steps.rows.empty()) {
      const double row_step = interpolate(steps.rows, std::min(col + patch_size / 2, grid.cols - 1));
      // Also without any step to go by (one row, no valid pair) the patch stays square.
      const double ratio = row_step > 0.0 && steps.column > 0.0 ? steps.column / row_step : 1.0;
      height = static_cast<int>(std::lround(std::min(kAspect * ratio, double{kMaxAspect}) * patch_size));
    }
    height = std::clamp(height, 2, std::max(2, grid.rows));
    out.strip_rows.push_back(height);
    out.strip_begin.push_back(out.strip_begin.back() + (grid.rows + height - 1) / height);
  }
}

// Sets patch_of_block of the blocks of strips [begin, end) to 0 that have valid pixels without a label.
void markOpenBlocks(const BeamGrid& grid, const LabelImage& done, int begin, int end, PatchGrid& out) {
  const int first_col = begin * out.strip_cols, last_col = std::min(end * out.strip_cols, grid.cols);
  const auto mark = [&out](int row, int col) {
    const int strip = col / out.strip_cols;
    out.patch_of_block[out.strip_begin[strip] + row / out.strip_rows[strip]] = 0;
  };
  for (int r = 0; r < grid.rows; ++r) {
    const float* const ranges = grid.range.data() + grid.index(r, 0);
    const std::int32_t* const labels = done.labels.data() + grid.index(r, 0);
    int c = first_col;
    for (; c + kLanes <= last_col; c += kLanes) {
      const LaneMask open = (loadLanes<Lanes>(ranges + c) > Lanes{}) & (loadLanes<LaneMask>(labels + c) <= LaneMask{});
      if (!anyLane(open)) continue;  // most pixels have a label
      for (int lane = 0; lane < kLanes; ++lane) {
        if (open[lane] != 0) mark(r, c + lane);
      }
    }
    for (; c < last_col; ++c) {
      if (ranges[c] > 0.0F && labels[c] <= 0) mark(r, c);
    }
  }
}

// Fills in patches from the sums of their blocks, four at a time, so that divisions of one are not waited for.
class PatchFitter {
 public:
  explicit PatchFitter(const Eigen::Vector3d& center) : center_(center) {}
  PatchFitter(const PatchFitter&) = delete;
  PatchFitter& operator=(const PatchFitter&) = delete;
  ~PatchFitter() {
    if (count_ > 0) fit();
  }

  /// Where to put the sums of the next patch.
  BlockSums& next() { return sums_[count_]; }
  /// Takes them for this one.
  void add(Patch& patch) {
    patches_[count_] = &patch;
    if (++count_ == kLanes) fit();
  }

 private:
  void fit() {
    const BlockTotals totals(sums_);
    const BlockMoments<Pair> first = totals.firstMoments(center_), last = totals.lastMoments(center_);
    const PlaneSolution<Pair> first_plane = solvePlane<Pair>(first), last_plane = solvePlane<Pair>(last);
    for (int k = 0; k < count_; ++k) {
      if (k < kPair) {
        finish(*patches_[k], first, first_plane, k, totals.points(k));
      } else {
        finish(*patches_[k], last, last_plane, k - kPair, totals.points(k));
      }
    }
    count_ = 0;
  }

  static void finish(Patch& out, const BlockMoments<Pair>& moments, const PlaneSolution<Pair>& plane, int k, int n) {
    out.moments = momentsOf(moments, k, n);
    out.fit = {Eigen::Vector3d(plane.ax[k], plane.ay[k], plane.az[k]), plane.chi2[k]};
    out.range = moments.ranges[k] / n;
  }

  const Eigen::Vector3d& center_;
  BlockSums sums_[kLanes];
  Patch* patches_[kLanes] = {};
  int count_ = 0;
};

// How many patches there are before each part of the bands, and in all.
void countBefore(int bands, const PatchGrid& grid, int threads, std::vector<int>& before) {
  const int parts = static_cast<int>(before.size()) - 1;
  before[0] = 0;
  forEachPart(threads, parts, [&](int part) {
    int count = 0;
    forEachBlock(grid, partBegin(bands, parts, part), partBegin(bands, parts, part + 1),
                 [&](int strip, int k) { count += grid.patch_of_block[grid.strip_begin[strip] + k] + 1; });
    before[part + 1] = count;
  });
  std::partial_sum(before.begin(), before.end(), before.begin());
}

// Numbers and lays out the patches of the blocks of a band that are marked, from `next` on. Returns what is next.
int listBand(const BeamGrid& grid, int band, int next, PatchGrid& out) {
  forEachBlock(out, band, band + 1, [&](int strip, int k) {
    int& index = out.patch_of_block[out.strip_begin[strip] + k];
    if (index < 0) return;
    Patch& patch = out.patches[next];
    index = next++;
    patch.row_begin = k * out.strip_rows[strip];
    patch.row_end = std::min(patch.row_begin + out.strip_rows[strip], grid.rows);
    patch.col_begin = strip * out.strip_cols;
    patch.col_end = std::min(patch.col_begin + out.strip_cols, grid.cols);
  });
  return next;
}

// Sums and fits the patches [begin, end).
// @param foresee called before each of them.
template <typename Choose, typename Foresee>
void sumPatches(const BeamGrid& grid, int begin, int end, const Choose& choose, const Foresee& foresee, PatchGrid& out) {
  PatchFitter fitter(out.center);
  for (int p = begin; p < end; ++p) {
    Patch& patch = out.patches[p];
    foresee(p);
    const PixelBlock block{patch.row_begin, patch.row_end, patch.col_begin, patch.col_end};
    if (sumPixels(grid, block, choose, fitter.next())) {
      fitter.add(patch);
    } else {
      patch.moments = Moments();
      patch.fit = PlaneFit();
      patch.range = 0.0;
    }
  }
}

// Lists and sums all blocks of bands [first, last), as patches from `begin` to `end`.
void sumAll(const BeamGrid& grid, int first, int last, int begin, int end, PatchGrid& out) {
  RowPrefetch rows(grid, first * kBandRows, std::min(grid.rows, (last + 1) * kBandRows), 2 * kBandRows + 2, end - begin);
  for (int band = first, next = begin; band < last; ++band) {
    const int from = next;
    next = listBand(grid, band, next, out);
    sumPatches(
        grid, from, next, [](int, int) { return fillMask(-1); }, [&](int) { rows.step(band * kBandRows); }, out);
  }
}

// Lists those that are left, here and there, of bands [first, last), and sums their pixels without a label.
void sumOpen(const BeamGrid& grid, const LabelImage& done, int first, int last, int begin, PatchGrid& out) {
  int end = begin;
  for (int band = first; band < last; ++band) end = listBand(grid, band, end, out);
  const auto open = [&done](int i, int pixels) { return labelsAt(done, i, pixels) <= LaneMask{}; };
  const auto fetch = [&](int p) {
    if (p + kFetchAhead >= end) return;
    const Patch& patch = out.patches[p + kFetchAhead];
    constexpr int kLine = 16;                                                // numbers fetched together
    if (patch.col_begin % kLine >= patch.col_end - patch.col_begin) return;  // have come with those of the patch before
    for (int r = patch.row_begin; r < patch.row_end; ++r) prefetchBeams(grid, grid.index(r, patch.col_begin));
  };
  sumPatches(grid, begin, end, open, fetch, out);
}

}  // namespace

void measureSteps(const BeamGrid& grid, PatchGridMemory& memory, AngularSteps& steps, int threads) {
  const int count = (grid.cols + 2 * kStepCols - 2) / kStepCols, ranges = rangeCount(threads, count);
  steps.rows.resize(static_cast<std::size_t>(count));  // at columns kStepCols apart, and the last one
  forEachPart(threads, 1 + ranges, memory.angles, [&](int part, std::vector<double>& angles) {
    if (part == 0) {
      steps.column = columnStep(grid, angles);
      return;
    }
    for (int k = partBegin(count, ranges, part - 1); k < partBegin(count, ranges, part); ++k) {
      steps.rows[k] = rowStep(grid, std::min(k * kStepCols, grid.cols - 1), angles);
    }
  });
}

void makePatchGrid(const BeamGrid& grid, int patch_size, const AngularSteps& steps, const LabelImage* done, int threads,
                   PatchGridMemory& memory, PatchGrid& out) {
  out.rows = grid.rows;
  out.cols = grid.cols;
  out.strip_cols = patch_size;
  out.center = sensorCenter(grid);
  out.truncated.clear();
  layOut(grid, patch_size, steps, out);
  out.patch_of_block.assign(static_cast<std::size_t>(out.strip_begin.back()), done == nullptr ? 0 : -1);
  if (done != nullptr) {
    forEachRange(threads, out.strips(), [&](int begin, int end) { markOpenBlocks(grid, *done, begin, end, out); });
  }
  const int bands = bandsOf(out), parts = rangeCount(threads, bands);
  std::vector<int>& before = memory.patches_before;
  before.resize(static_cast<std::size_t>(parts) + 1);
  countBefore(bands, out, threads, before);
  out.patches.resize(static_cast<std::size_t>(before.back()));
  forEachPart(threads, parts, [&](int part) {
    const int first = partBegin(bands, parts, part), last = partBegin(bands, parts, part + 1);
    if (done == nullptr) {
      sumAll(grid, first, last, before[part], before[part + 1], out);
    } else {
      sumOpen(grid, *done, first, last, before[part], out);
    }
  });
  linkPatches(threads, memory, out);
}

PatchGrid makePatchGrid(const BeamGrid& grid, int patch_size, bool equal_angle, const LabelImage* done, int threads) {
  PatchGridMemory memory;
  AngularSteps steps;
  if (equal_angle) measureSteps(grid, memory, steps);
  PatchGrid out;
  makePatchGrid(grid, patch_size, steps, done, threads, memory, out);
  return out;
}

}  // namespace ppc
