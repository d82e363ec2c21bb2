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
      : patches_(patches), shares_(shares), only_(only), reached_(patches.patches.size(), -1) {}

  /// In ascending order.
  const std::vector<std::int32_t>& labelsAround(int index) {
    labels_.clear();
    // Most patches are come upon several times, and most of them have one label, or that of one before.
    std::int32_t last = 0, other = 0;
    const std::int32_t* const only = only_.data();
    const auto look = [&](int i) {
      const std::int32_t label = only[i];
      if (label == last || label == other || label == 0) return;
      if (label > 0) {
        other = last;
        add(last = label);
      } else if (reached_[i] != index) {
        reached_[i] = index;
        for (int s = shares_.begin[i]; s < shares_.begin[i + 1]; ++s) add(shares_.shares[s].label);
      }
    };
    look(index);
    patches_.forEachNeighbour(index, [&](int near) {
      look(near);
      patches_.forEachNeighbour(near, look);
    });
    return labels_;
  }

 private:
  void add(std::int32_t label) {
    auto at = labels_.begin();
    while (at != labels_.end() && *at < label) ++at;
    if (at == labels_.end() || *at != label) labels_.insert(at, label);
  }

  const PatchGrid& patches_;
  const CellShares& shares_;
  const std::vector<std::int32_t>& only_;
  std::vector<int> reached_;  // the last patch from which each with several labels was reached
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
  const std::vector<std::int32_t> only = onlyLabels(shares, threads);

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

std::vector<int> contestLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                               const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                               const CoplanarityTolerance& tolerance, LabelImage& labels, int threads) {
  const std::vector<std::int32_t> only = onlyLabels(shares, threads);
  const int count = static_cast<int>(only.size()), parts = threads > 1 ? 4 * threads : 1;
  std::vector<std::vector<int>> changed(static_cast<std::size_t>(parts));
  forEachPart(threads, parts, [&](int part) {
    CellResolver resolver(grid, cells, planes, noise, tolerance);
    Neighbourhood neighbourhood(cells, shares, only);
    for (int k = partBegin(count, parts, part), end = partBegin(count, parts, part + 1); k < end; ++k) {
      if (!isBorderCell(cells, only, k)) continue;
      if (resolver.resolve(cells.patches[k], neighbourhood.labelsAround(k), 1, true, labels)) changed[part].push_back(k);
    }
  });
  for (int part = 1; part < parts; ++part) changed[0].insert(changed[0].end(), changed[part].begin(), changed[part].end());
  return std::move(changed[0]);
}

}  // namespace ppc
