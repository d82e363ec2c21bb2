// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_shares.h"

#include "patch_plane_clustering/core/block_moments.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace ppc {
namespace {

// Whether a block of labels has the same everywhere.
bool uniform(const std::int32_t* corner, int rows, int cols, int stride) {
  const LaneMask label = fillMask(*corner);
  const int whole = cols - cols % kLanes;
  LaneMask others = {};
  for (int r = 0; r < rows; ++r) {
    const std::int32_t* row = corner + static_cast<std::ptrdiff_t>(r) * stride;
    for (int c = 0; c < whole; c += kLanes) others |= loadLanes<LaneMask>(row + c) != label;
    for (int c = whole; c < cols; ++c) others[0] |= row[c] ^ *corner;
  }
  return !anyLane(others);
}

// Valid pixels of a label in a cell.
int countPixels(const BeamGrid& grid, const Patch& cell, const LabelImage& labels, std::int32_t label) {
  int count = 0;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
      count += labels.labels[i] == label && grid.valid(i) ? 1 : 0;
    }
  }
  return count;
}

// Adds the shares of one cell.
void shareCell(const BeamGrid& grid, const Patch& cell, const Eigen::Vector3d& center, const NoiseModel& noise,
               const LabelImage& labels, std::vector<std::int32_t>& found, CellShares& out) {
  // The usual cases first: one label on all pixels, or none.
  const std::int32_t* corner = labels.labels.data() + grid.index(cell.row_begin, cell.col_begin);
  if (uniform(corner, cell.row_end - cell.row_begin, cell.col_end - cell.col_begin, labels.cols)) {
    if (*corner > 0 && cell.moments.n > 0) out.shares.push_back({*corner, cell.moments});
    return;
  }
  found.clear();
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
      const std::int32_t label = labels.labels[i];
      if (label > 0 && std::find(found.begin(), found.end(), label) == found.end()) found.push_back(label);
    }
  }
  for (const std::int32_t label : found) {
    if (found.size() == 1 && countPixels(grid, cell, labels, label) == cell.moments.n) {  // the patch's own sums serve
      out.shares.push_back({label, cell.moments});
      continue;
    }
    const BlockSums sums = sumPixels(grid, cell.row_begin, cell.row_end, cell.col_begin, cell.col_end,
                                     [&](int i, int count) { return labelsAt(labels, i, count) == fillMask(label); });
    if (sums.empty) continue;
    const int n = countLanes(sums.counted);
    const BlockMoments<double> block = momentsOf(sums, center);
    const double sigma = noise.sigma(block.ranges / n);
    out.shares.push_back({label, momentsOf(block, 0, n)});
    out.shares.back().moments.scale(1.0 / (sigma * sigma));
  }
}

}  // namespace

std::vector<Moments> sumShares(const CellShares& cells) {
  std::int32_t highest = 0;
  for (const CellShares::Share& share : cells.shares) highest = std::max(highest, share.label);
  std::vector<Moments> sums(static_cast<std::size_t>(highest) + 1);
  for (const CellShares::Share& share : cells.shares) sums[share.label] += share.moments;
  return sums;
}

void renameShares(const std::vector<std::int32_t>& names, CellShares& cells) {
  std::size_t out = 0;
  for (std::size_t k = 0; k + 1 < cells.begin.size(); ++k) {
    const std::size_t first = out;
    const int begin = cells.begin[k], end = cells.begin[k + 1];
    cells.begin[k] = static_cast<int>(first);
    if (end - begin == 1 && static_cast<int>(first) == begin) {  // nothing to move
      cells.shares[first].label = names[cells.shares[first].label];
      ++out;
      continue;
    }
    for (int s = begin; s < end; ++s) {
      const CellShares::Share share = {names[cells.shares[s].label], cells.shares[s].moments};
      std::size_t at = first;
      while (at < out && cells.shares[at].label != share.label) ++at;
      if (at < out) {
        cells.shares[at].moments += share.moments;
      } else {
        cells.shares[out++] = share;
      }
    }
  }
  cells.begin.back() = static_cast<int>(out);
  cells.shares.resize(out);
}

CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                      int threads) {
  CellShares shares, memory;
  updateShares(grid, cells, noise, labels, std::vector<char>(cells.patches.size(), 1), shares, memory, threads);
  return shares;
}

void shareClusters(const PatchGrid& patches, const std::vector<int>& cluster_of, CellShares& shares) {
  shares.begin.clear();
  shares.shares.clear();
  for (std::size_t k = 0; k < patches.patches.size(); ++k) {
    shares.begin.push_back(static_cast<int>(shares.shares.size()));
    if (cluster_of[k] >= 0) shares.shares.push_back({cluster_of[k] + 1, patches.patches[k].moments});
  }
  shares.begin.push_back(static_cast<int>(shares.shares.size()));
}

CellLabels::CellLabels(const CellShares& shares, int threads)
    : begin(shares.begin), labels(shares.shares.size()), only(shares.begin.size() - 1) {
  forEachRange(threads, static_cast<int>(only.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const int share = begin[i], count = begin[i + 1] - share;
      for (int s = share; s < share + count; ++s) labels[s] = shares.shares[s].label;
      only[i] = count == 1 ? labels[share] : count == 0 ? 0 : -1;
    }
  });
}

void updateShares(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                  const std::vector<char>& changed, CellShares& shares, CellShares& memory, int threads) {
  std::swap(shares, memory);
  const CellShares& before = memory;
  const int count = static_cast<int>(cells.patches.size());
  const int parts = std::max(1, threads);
  std::vector<CellShares> rest(static_cast<std::size_t>(parts - 1));  // the first part's go where all will be
  forEachPart(threads, parts, [&](int part) {
    CellShares& mine = part == 0 ? shares : rest[part - 1];
    mine.begin.clear();
    mine.shares.clear();
    std::vector<std::int32_t> scratch;
    const int part_end = partBegin(count, parts, part + 1);
    for (int k = partBegin(count, parts, part), next = k; k < part_end; k = next) {
      const auto size = static_cast<int>(mine.shares.size());
      if (changed[k] != 0) {
        next = k + 1;
        mine.begin.push_back(size);
        shareCell(grid, cells.patches[k], cells.center, noise, labels, scratch, mine);
        continue;
      }
      while (next < part_end && changed[next] == 0) ++next;
      const int first = before.begin[k];
      for (int same = k; same < next; ++same) mine.begin.push_back(size + before.begin[same] - first);
      mine.shares.insert(mine.shares.end(), before.shares.begin() + first, before.shares.begin() + before.begin[next]);
    }
  });
  for (const CellShares& part : rest) {
    const auto offset = static_cast<int>(shares.shares.size());
    for (const int begin : part.begin) shares.begin.push_back(offset + begin);
    shares.shares.insert(shares.shares.end(), part.shares.begin(), part.shares.end());
  }
  shares.begin.push_back(static_cast<int>(shares.shares.size()));
}

std::vector<Eigen::Vector3d> labelPlanes(const CellShares& cells) {
  const std::vector<Moments> sums = sumShares(cells);
  std::vector<Eigen::Vector3d> planes;
  planes.reserve(sums.size());
  for (const Moments& m : sums) planes.push_back(fitPlane(m).a);
  return planes;
}

}  // namespace ppc
