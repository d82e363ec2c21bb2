// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/refinement.h"

#include "patch_plane_clustering/core/cell_outliers.h"
#include "patch_plane_clustering/core/cell_resolver.h"
#include "patch_plane_clustering/core/labels_around.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>

namespace ppc {
namespace {

// Cells whose place, and whose beams, are fetched ahead.
constexpr std::size_t kCellsAhead = 6, kBeamsAhead = 2;
constexpr int kMiddlesAhead = 8;  // likewise, of cells amid regions

// Resolves cells among the labels around them. @param which left with those whose labels have changed.
void resolveCells(const PatchGrid& cells, LabelsAround& around, std::vector<int>& which, std::int32_t first_open, bool keep,
                  CellResolver& resolver, LabelImage& labels) {
  std::size_t kept = 0;
  for (std::size_t j = 0; j < which.size(); ++j) {
    if (j + kCellsAhead < which.size()) __builtin_prefetch(&cells.patches[which[j + kCellsAhead]]);
    if (j + kBeamsAhead < which.size()) resolver.prefetch(cells.patches[which[j + kBeamsAhead]], labels);
    const int k = which[j];
    if (resolver.resolve(cells.patches[k], around.find(k), first_open, keep, labels)) which[kept++] = k;
  }
  which.resize(kept);
}

}  // namespace

void refineLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                  const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                  std::int32_t first_open, RefinementMemory& memory, LabelImage& labels, std::vector<char>& changed,
                  int threads) {
  const int count = static_cast<int>(cells.patches.size());
  changed.assign(cells.patches.size(), 0);

  // The label of cells that have just one, whole; 0 of all others, kEmpty of those that have no points.
  constexpr std::int32_t kEmpty = -1;
  std::vector<std::int32_t>& whole = memory.whole;
  std::vector<char>& open = memory.open;
  whole.resize(cells.patches.size());
  open.resize(cells.patches.size());
  const int ranges = rangeCount(threads, count);
  forEachPart(threads, 1 + ranges, [&](int part) {
    if (part == 0) return memory.blocks.list(cells, shares);
    for (int k = partBegin(count, ranges, part - 1), end = partBegin(count, ranges, part); k < end; ++k) {
      const int first = shares.begin[k], last = shares.begin[k + 1];
      if (last - first == 1 && shares.parts[first] == CellShares::kWhole) {  // as most are
        whole[k] = shares.labels[first];
        open[k] = shares.labels[first] >= first_open ? 1 : 0;
        continue;
      }
      const int points = cells.patches[k].moments.n;
      int labelled = 0;
      bool newly = false;
      for (int s = first; s < last; ++s) {
        labelled += shares.momentsOf(cells, k, s).n;
        newly = newly || shares.labels[s] >= first_open;
      }
      const bool full = labelled == points;
      whole[k] = points == 0 ? kEmpty : full && shares.only[k] > 0 ? shares.only[k] : 0;
      open[k] = points > 0 && (newly || !full) ? 1 : 0;
    }
  });
  forEachRange(threads, count, memory.of_thread, [&](int begin, int end, RefinementMemory::OfThread& mine) {
    CellResolver resolver(grid, cells, planes, noise, tolerance, mine.resolver);
    LabelsAround around(cells, shares, memory.blocks, mine.around);
    const CellOutliers outliers(grid, cells.center, planes, noise, tolerance);
    std::vector<int>& found = mine.cells;
    found.clear();
    for (int k = begin; k < end; ++k) {
      if (k + kMiddlesAhead < end && open[k + kMiddlesAhead] != 0) outliers.prefetch(cells.patches[k + kMiddlesAhead]);
      if (open[k] == 0) continue;
      const std::int32_t own = whole[k];
      bool inside = own > 0;
      cells.forEachNeighbour(k, [&](int j) { inside = inside && (whole[j] == own || whole[j] == kEmpty); });
      if (!inside) {
        found.push_back(k);
      } else if (outliers.clear(cells.patches[k], own, labels)) {
        changed[k] = 1;
      }
    }
    resolveCells(cells, around, found, first_open, false, resolver, labels);
    for (const int k : found) changed[k] = 1;
  });
}

void contestLabels(const BeamGrid& grid, const PatchGrid& cells, const CellShares& shares,
                   const std::vector<Eigen::Vector3d>& planes, const NoiseModel& noise,
                   const CoplanarityTolerance& tolerance, RefinementMemory& memory, LabelImage& labels, int threads) {
  memory.blocks.list(cells, shares);
  const int count = static_cast<int>(shares.only.size()), parts = threads > 1 ? 4 * threads : 1;
  forEachPart(threads, parts, memory.of_thread, [&](int part, RefinementMemory::OfThread& mine) {
    CellResolver resolver(grid, cells, planes, noise, tolerance, mine.resolver);
    LabelsAround around(cells, shares, memory.blocks, mine.around);
    std::vector<int>& borders = mine.cells;
    borders.clear();
    for (int k = partBegin(count, parts, part), end = partBegin(count, parts, part + 1); k < end; ++k) {
      if (isBorderCell(cells, shares.only, k)) borders.push_back(k);
    }
    resolveCells(cells, around, borders, 1, true, resolver, labels);
  });
}

}  // namespace ppc
