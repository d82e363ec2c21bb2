// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc {
namespace {

constexpr float kCap = 9.0F;              // squared residual beyond which a point is an outlier: three sigma
constexpr float kMaxWindowCost = 5.0F;    // mean capped cost over the window that a plane may have
constexpr float kMaxOwnResidual = 12.0F;  // squared residual of the point itself

// Squared residuals of the pixels of a cell against one plane, in units of their variance. The tolerance's share of the
// variance changes little over a cell: it is taken at one pixel.
class CellResiduals {
 public:
  CellResiduals(const BeamGrid& grid, const Eigen::Vector3f& center, const NoiseModel& noise, float floor, int pixel,
                const Eigen::Vector3f& a)
      : grid_(grid), center_(center), a_(a) {
    const float range = grid.range[pixel];
    const float along = a.dot(grid.direction(pixel));
    const float sec2 = std::min(30.0F, a.squaredNorm() / (along * along));
    const auto sigma = static_cast<float>(noise.sigma(range));
    const float variance = sigma * sigma + floor * floor * sec2;
    precision_ = 1.0F / variance;
    log_variance_ = std::log(variance / (sigma * sigma));
  }

  float operator()(int i) const {
    const float along = a_.dot(grid_.direction(i));
    const float model = (1.0F - a_.dot(grid_.origin(i) - center_)) / along;
    const float e = grid_.range[i] - model;
    return model > 0.0F ? e * e * precision_ : std::numeric_limits<float>::infinity();
  }

  /// Logarithm of the variance over that of the noise alone: a lenient plane explains everything, but nothing well.
  float logVariance() const { return log_variance_; }

 private:
  const BeamGrid& grid_;
  Eigen::Vector3f center_, a_;
  float precision_ = 0.0F, log_variance_ = 0.0F;
};

// The valid pixel nearest to the middle of a cell, in scan order; -1 if there is none.
int middlePixel(const BeamGrid& grid, const Patch& cell) {
  int middle = -1, valid = 0;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int c = cell.col_begin; c < cell.col_end; ++c) {
      const int i = grid.index(r, c);
      if (grid.valid(i) && 2 * valid++ <= cell.moments.n) middle = i;
    }
  }
  return middle;
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

 private:
  const PatchGrid& patches_;
  std::vector<int> reached_;  // the last patch from which each was reached
  std::vector<int> found_;
};

void paint(const BeamGrid& grid, const Patch& patch, std::int32_t label, LabelImage& out) {
  for (int r = patch.row_begin; r < patch.row_end; ++r) {
    for (int c = patch.col_begin; c < patch.col_end; ++c) {
      const int i = grid.index(r, c);
      if (grid.valid(i)) out.labels[i] = label;
    }
  }
}

LabelImage emptyLabels(const BeamGrid& grid) {
  return {grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
}

// Resolves the points of one patch among candidate clusters.
class PatchResolver {
 public:
  PatchResolver(const BeamGrid& grid, const PatchGrid& patches, const std::vector<Eigen::Vector3d>& planes,
                const NoiseModel& noise, const CoplanarityTolerance& tolerance)
      : grid_(grid),
        patches_(patches),
        planes_(planes),
        noise_(noise),
        center_(patches.center.cast<float>()),
        floor_(static_cast<float>(tolerance.sigma_distance)) {}

  CellResiduals residuals(int pixel, std::int32_t label) const {
    return CellResiduals(grid_, center_, noise_, floor_, pixel, planes_[label].cast<float>());
  }

  void resolve(const Patch& patch, const std::vector<std::int32_t>& candidates, std::int32_t first_open, LabelImage& out) {
    const int strip = patch.col_begin / patches_.strip_cols;
    const int reach_rows = std::max(1, patches_.strip_rows[strip] / patches_.strip_cols);
    const int top = std::max(0, patch.row_begin - reach_rows), bottom = std::min(grid_.rows, patch.row_end + reach_rows);
    const int left = std::max(0, patch.col_begin - 1), right = std::min(grid_.cols, patch.col_end + 1);
    const int width = right - left;
    const std::size_t size = static_cast<std::size_t>(bottom - top) * width;
    const int middle = middlePixel(grid_, patch);
    if (middle < 0) return;
    best_.assign(size, std::numeric_limits<float>::infinity());
    winner_.assign(size, 0);
    for (const std::int32_t candidate : candidates) {
      const CellResiduals squared = residuals(middle, candidate);
      cost_.assign(size, -1.0F);
      own_.assign(size, 0.0F);
      for (int r = top; r < bottom; ++r) {
        for (int c = left; c < right; ++c) {
          const int i = grid_.index(r, c);
          if (!grid_.valid(i)) continue;
          const std::size_t at = static_cast<std::size_t>(r - top) * width + (c - left);
          own_[at] = squared(i);
          cost_[at] = std::min(own_[at], kCap);
        }
      }
      for (int r = patch.row_begin; r < patch.row_end; ++r) {
        for (int c = patch.col_begin; c < patch.col_end; ++c) {
          const std::size_t at = static_cast<std::size_t>(r - top) * width + (c - left);
          if (cost_[at] < 0.0F || own_[at] > kMaxOwnResidual) continue;
          float sum = 0.0F;
          int n = 0;
          for (int y = std::max(top, r - reach_rows); y < std::min(bottom, r + reach_rows + 1); ++y) {
            for (int x = std::max(left, c - 1); x < std::min(right, c + 2); ++x) {
              const float cost = cost_[static_cast<std::size_t>(y - top) * width + (x - left)];
              if (cost < 0.0F) continue;
              sum += cost;
              ++n;
            }
          }
          const float mean = sum / static_cast<float>(n);
          if (mean < kMaxWindowCost && mean + squared.logVariance() < best_[at]) {
            best_[at] = mean + squared.logVariance();
            winner_[at] = candidate;
          }
        }
      }
    }
    for (int r = patch.row_begin; r < patch.row_end; ++r) {
      for (int c = patch.col_begin; c < patch.col_end; ++c) {
        const int i = grid_.index(r, c);
        if (out.labels[i] > 0 && out.labels[i] < first_open) continue;
        out.labels[i] = winner_[static_cast<std::size_t>(r - top) * width + (c - left)];
      }
    }
  }

 private:
  const BeamGrid& grid_;
  const PatchGrid& patches_;
  const std::vector<Eigen::Vector3d>& planes_;
  const NoiseModel& noise_;
  Eigen::Vector3f center_;
  float floor_;
  std::vector<float> cost_, own_, best_;
  std::vector<std::int32_t> winner_;
};

}  // namespace

LabelImage patchLabels(const BeamGrid& grid, const PatchGrid& patches, const PatchClusters& clusters) {
  LabelImage out = emptyLabels(grid);
  for (std::size_t p = 0; p < patches.patches.size(); ++p) {
    if (clusters.cluster_of[p] >= 0) paint(grid, patches.patches[p], clusters.cluster_of[p] + 1, out);
  }
  return out;
}

LabelImage refineLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares, const LabelImage& labels,
                        const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                        const CoplanarityTolerance& tolerance, std::int32_t first_open) {
  LabelImage out = labels;
  PatchResolver resolver(grid, cells, planes, noise, tolerance);
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
  Neighbourhood neighbourhood(cells);
  std::vector<std::int32_t> candidates;
  for (int k = 0; k < count; ++k) {
    const Patch& cell = cells.patches[k];
    if (cell.moments.n == 0 || !open[k]) continue;
    const std::int32_t own = whole[k];
    bool inside = own > 0;
    cells.forEachNeighbour(k, [&](int j) { inside = inside && (whole[j] == own || cells.patches[j].moments.n == 0); });
    if (inside) {
      const CellResiduals squared = resolver.residuals(middlePixel(grid, cell), own);
      for (int r = cell.row_begin; r < cell.row_end; ++r) {
        for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
          if (!grid.valid(i) || squared(i) > kMaxOwnResidual) out.labels[i] = 0;
        }
      }
      continue;
    }
    candidates.clear();
    for (const int j : neighbourhood.around(k)) {
      for (int s = shares.begin[j]; s < shares.begin[j + 1]; ++s) {
        const std::int32_t label = shares.shares[s].label;
        if (std::find(candidates.begin(), candidates.end(), label) == candidates.end()) candidates.push_back(label);
      }
    }
    std::sort(candidates.begin(), candidates.end());
    resolver.resolve(cell, candidates, first_open, out);
  }
  return out;
}

void splitComponents(int gap_rows, int gap_cols, LabelImage& labels) {
  // Runs of equal labels along the rows, gaps bridged; runs of nearby rows that overlap belong together.
  struct Run {
    int begin, end, parent;
    std::int32_t label;
  };
  std::vector<Run> runs;
  std::vector<int> row_begin(static_cast<std::size_t>(labels.rows) + 1, 0);
  std::vector<int> run_of(labels.labels.size(), -1);
  for (int r = 0; r < labels.rows; ++r) {
    row_begin[r] = static_cast<int>(runs.size());
    for (int c = 0; c < labels.cols; ++c) {
      const std::size_t i = static_cast<std::size_t>(r) * labels.cols + c;
      const std::int32_t label = labels.labels[i];
      if (label == 0) continue;
      int run = -1;
      for (int k = static_cast<int>(runs.size()) - 1; k >= row_begin[r] && runs[k].end + gap_cols >= c; --k) {
        if (runs[k].label == label) {
          run = k;
          break;
        }
      }
      if (run < 0) {
        run = static_cast<int>(runs.size());
        runs.push_back({c, c, run, label});
      }
      runs[run].end = c + 1;
      run_of[i] = run;
    }
  }
  row_begin[labels.rows] = static_cast<int>(runs.size());
  const auto find = [&](int i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
  };
  for (int r = 1; r < labels.rows; ++r) {
    for (int back = 1; back <= std::min(r, gap_rows + 1); ++back) {
      int above = row_begin[r - back];
      const int above_end = row_begin[r - back + 1];
      for (int k = row_begin[r]; k < row_begin[r + 1]; ++k) {
        for (int j = above; j < above_end; ++j) {
          if (runs[j].label != runs[k].label || runs[j].begin >= runs[k].end || runs[k].begin >= runs[j].end) continue;
          const int a = find(j), b = find(k);
          runs[std::max(a, b)].parent = std::min(a, b);
        }
        while (above < above_end && runs[above].end <= runs[k].begin) ++above;
      }
    }
  }
  std::vector<std::int32_t> renamed(runs.size(), 0);
  std::int32_t next = 0;
  for (std::size_t i = 0; i < run_of.size(); ++i) {
    if (run_of[i] < 0) continue;
    const int root = find(run_of[i]);
    if (renamed[root] == 0) renamed[root] = ++next;
    labels.labels[i] = renamed[root];
  }
}

}  // namespace ppc
