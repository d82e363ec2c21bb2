// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace patch_plane_clustering {
namespace {

constexpr float kCap = 9.0F;              // squared residual beyond which a point is an outlier: three sigma
constexpr float kMaxWindowCost = 5.0F;    // mean capped cost over the window that a plane may have
constexpr float kMaxOwnResidual = 12.0F;  // squared residual of the point itself

// Squared residual of a pixel against a plane, in units of its variance, and the log of that variance.
struct Residual {
  float z2;
  float log_variance;
};

class PlaneResiduals {
 public:
  PlaneResiduals(const BeamGrid& grid, const Eigen::Vector3d& center, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance)
      : grid_(grid), center_(center.cast<float>()), noise_(noise) {
    floor_ = static_cast<float>(tolerance.sigma_distance * tolerance.sigma_distance);
  }

  Residual operator()(int i, const Eigen::Vector3f& a) const {
    const float r = grid_.range[i];
    const Eigen::Vector3f u = grid_.direction(i);
    const float along = a.dot(u);
    const float model = (1.0F - a.dot(grid_.origin(i) - center_)) / along;
    if (!(model > 0.0F)) return {std::numeric_limits<float>::infinity(), 0.0F};
    const auto sigma = static_cast<float>(noise_.sigma(r));
    const float sec2 = std::min(30.0F, a.squaredNorm() / (along * along));
    const float extra = floor_ * sec2 / (sigma * sigma);
    const float e = (r - model) / sigma;
    return {e * e / (1.0F + extra), std::log(1.0F + extra)};
  }

 private:
  const BeamGrid& grid_;
  Eigen::Vector3f center_;
  const NoiseModel& noise_;
  float floor_ = 0.0F;
};

// Patches within two steps of a patch, itself included, in ascending order.
void neighbourhood(const PatchGrid& patches, int index, std::vector<int>& out) {
  out.assign(1, index);
  for (int step = 0; step < 2; ++step) {
    const std::size_t end = out.size();
    for (std::size_t i = 0; i < end; ++i) patches.forEachNeighbour(out[i], [&](int j) { out.push_back(j); });
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
  }
}

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
                const PlaneResiduals& residuals)
      : grid_(grid), patches_(patches), planes_(planes), residuals_(residuals) {}

  void resolve(const Patch& patch, const std::vector<std::int32_t>& candidates, LabelImage& out) {
    const int strip = patch.col_begin / patches_.strip_cols;
    const int reach_rows = std::max(1, patches_.strip_rows[strip] / patches_.strip_cols);
    const int top = std::max(0, patch.row_begin - reach_rows), bottom = std::min(grid_.rows, patch.row_end + reach_rows);
    const int left = std::max(0, patch.col_begin - 1), right = std::min(grid_.cols, patch.col_end + 1);
    const int width = right - left;
    const std::size_t size = static_cast<std::size_t>(bottom - top) * width;
    best_.assign(size, kMaxWindowCost);
    winner_.assign(size, 0);
    for (const std::int32_t candidate : candidates) {
      const Eigen::Vector3f a = planes_[candidate].cast<float>();
      cost_.assign(size, -1.0F);
      own_.assign(size, 0.0F);
      for (int r = top; r < bottom; ++r) {
        for (int c = left; c < right; ++c) {
          const int i = grid_.index(r, c);
          if (!grid_.valid(i)) continue;
          const Residual residual = residuals_(i, a);
          const std::size_t at = static_cast<std::size_t>(r - top) * width + (c - left);
          own_[at] = residual.z2;
          cost_[at] = std::min(residual.z2, kCap) + residual.log_variance;
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
          if (mean < best_[at]) {
            best_[at] = mean;
            winner_[at] = candidate;
          }
        }
      }
    }
    for (int r = patch.row_begin; r < patch.row_end; ++r) {
      for (int c = patch.col_begin; c < patch.col_end; ++c) {
        out.labels[grid_.index(r, c)] = winner_[static_cast<std::size_t>(r - top) * width + (c - left)];
      }
    }
  }

 private:
  const BeamGrid& grid_;
  const PatchGrid& patches_;
  const std::vector<Eigen::Vector3d>& planes_;
  const PlaneResiduals& residuals_;
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

LabelImage refineLabels(const BeamGrid& grid, const PatchGrid& cells, const LabelImage& labels,
                        const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                        const CoplanarityTolerance& tolerance) {
  LabelImage out = emptyLabels(grid);
  const PlaneResiduals residuals(grid, cells.center, noise, tolerance);
  PatchResolver resolver(grid, cells, planes, residuals);

  std::vector<std::vector<std::int32_t>> seen(cells.patches.size());  // labels in each cell; 0 if some pixel has none
  for (std::size_t k = 0; k < cells.patches.size(); ++k) {
    const Patch& cell = cells.patches[k];
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      for (int c = cell.col_begin; c < cell.col_end; ++c) {
        const int i = grid.index(r, c);
        if (!grid.valid(i)) continue;
        const std::int32_t label = labels.labels[i];
        if (std::find(seen[k].begin(), seen[k].end(), label) == seen[k].end()) seen[k].push_back(label);
      }
    }
  }
  std::vector<int> around;
  std::vector<std::int32_t> candidates;
  for (int k = 0; k < static_cast<int>(cells.patches.size()); ++k) {
    if (seen[k].empty()) continue;
    const Patch& cell = cells.patches[k];
    const std::int32_t own = seen[k].size() == 1 ? seen[k].front() : 0;
    bool inside = own > 0;
    cells.forEachNeighbour(k, [&](int j) { inside = inside && seen[j].size() <= 1 && (seen[j].empty() || seen[j][0] == own); });
    if (inside) {
      const Eigen::Vector3f a = planes[own].cast<float>();
      for (int r = cell.row_begin; r < cell.row_end; ++r) {
        for (int c = cell.col_begin; c < cell.col_end; ++c) {
          const int i = grid.index(r, c);
          if (grid.valid(i) && residuals(i, a).z2 <= kMaxOwnResidual) out.labels[i] = own;
        }
      }
      continue;
    }
    neighbourhood(cells, k, around);
    candidates.clear();
    for (const int j : around) {
      for (const std::int32_t label : seen[j]) {
        if (label > 0) candidates.push_back(label);
      }
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    if (!candidates.empty()) resolver.resolve(cell, candidates, out);
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

}  // namespace patch_plane_clustering
