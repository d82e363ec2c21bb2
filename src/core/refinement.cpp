// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include "patch_plane_clustering/core/cell_resolver.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstring>

namespace ppc {
namespace {

// Finds the labels of patches within two steps of a patch, itself included.
class Neighbourhood {
 public:
  /// @param only see onlyLabels().
  Neighbourhood(const PatchGrid& patches, const CellShares& shares, const std::vector<std::int32_t>& only)
      : patches_(patches),
        shares_(shares),
        only_(only),
        reached_(patches.patches.size(), -1),
        found_(patches.patches.size()) {}

  /// In ascending order.
  const std::vector<std::int32_t>& labelsAround(int index) {
    labels_.clear();
    int* const reached = reached_.data();
    int* const found = found_.data();
    int size = 0;
    const auto take = [&](int i) {
      if (reached[i] == index) return;
      reached[i] = index;
      found[size++] = i;
    };
    take(index);
    for (int step = 0, next = 0; step < 2; ++step) {
      for (const int end = size; next < end; ++next) patches_.forEachNeighbour(found[next], take);
    }
    std::int32_t last = 0;
    for (int k = 0; k < size; ++k) {
      const std::int32_t label = only_[found[k]];
      if (label == last) continue;
      if (label > 0) {
        add(last = label);
      } else if (label < 0) {
        for (int s = shares_.begin[found[k]]; s < shares_.begin[found[k] + 1]; ++s) add(shares_.shares[s].label);
      }
    }
    return labels_;
  }

 private:
  void add(std::int32_t label) {
    const auto at = std::lower_bound(labels_.begin(), labels_.end(), label);
    if (at == labels_.end() || *at != label) labels_.insert(at, label);
  }

  const PatchGrid& patches_;
  const CellShares& shares_;
  const std::vector<std::int32_t>& only_;
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
  const std::vector<std::int32_t> only = onlyLabels(shares);

  // The label of cells that have just one, whole; 0 of all others.
  std::vector<std::int32_t> whole(cells.patches.size());
  std::vector<char> open(cells.patches.size());
  forEachRange(threads, count, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      int labelled = 0;
      bool newly = false;
      for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
        labelled += shares.shares[s].moments.n;
        newly = newly || shares.shares[s].label >= first_open;
      }
      const bool full = labelled == cells.patches[k].moments.n;
      whole[k] = full && only[k] > 0 ? only[k] : 0;
      open[k] = newly || !full ? 1 : 0;
    }
  });
  forEachRange(threads, count, [&](int begin, int end) {
    CellResolver resolver(grid, cells, planes, noise, tolerance);
    Neighbourhood neighbourhood(cells, shares, only);
    for (int k = begin; k < end; ++k) {
      const Patch& cell = cells.patches[k];
      if (cell.moments.n == 0 || open[k] == 0) continue;
      const std::int32_t own = whole[k];
      bool inside = own > 0;
      cells.forEachNeighbour(k, [&](int j) { inside = inside && (whole[j] == own || cells.patches[j].moments.n == 0); });
      if (inside) {
        if (resolver.clearOutliers(cell, own, labels)) changed[k] = 1;
        continue;
      }
      resolver.resolve(cell, neighbourhood.labelsAround(k), first_open, false, labels);
      changed[k] = 1;
    }
  });
}

void contestLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, LabelImage& labels, int threads) {
  const std::vector<std::int32_t> only = onlyLabels(shares);
  const std::vector<int> border = borderCells(cells, only);
  forEachRange(threads, static_cast<int>(border.size()), [&](int begin, int end) {
    CellResolver resolver(grid, cells, planes, noise, tolerance);
    Neighbourhood neighbourhood(cells, shares, only);
    for (int k = begin; k < end; ++k) {
      resolver.resolve(cells.patches[border[k]], neighbourhood.labelsAround(border[k]), 1, true, labels);
    }
  });
}

}  // namespace ppc
