// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_shares.h"

#include "patch_plane_clustering/core/block_moments.h"
#include "patch_plane_clustering/core/cell_prefetch.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace ppc {
namespace {

// Cells whose place, and whose pixels, are fetched ahead.
constexpr std::size_t kCellsAhead = 6, kBeamsAhead = 2;

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

// Lists the labels of a cell's pixels as they come row by row.
void findLabels(const Patch& cell, const LabelImage& labels, std::vector<std::int32_t>& found) {
  found.clear();
  LaneMask last = {}, other = {};  // found last
  const auto look = [&](LaneMask four) {
    if (!anyLane((four > LaneMask{}) & (four != last) & (four != other))) return;
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int32_t label = four[lane];
      if (label <= 0 || std::find(found.begin(), found.end(), label) != found.end()) continue;
      found.push_back(label);
      other = last;
      last = fillMask(label);
    }
  };
  const std::int32_t* row = labels.labels.data() + static_cast<std::ptrdiff_t>(cell.row_begin) * labels.cols;
  const int whole = cell.col_end - (cell.col_end - cell.col_begin) % kLanes;
  for (int r = cell.row_begin; r < cell.row_end; ++r, row += labels.cols) {
    for (int c = cell.col_begin; c < whole; c += kLanes) look(loadLanes<LaneMask>(row + c));
    if (whole < cell.col_end) look(loadLanes<LaneMask>(row + whole, cell.col_end - whole));
  }
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

void addShare(std::int32_t label, int part, CellShares& out) {
  out.labels.push_back(label);
  out.parts.push_back(part);
}

// Adds the shares of one cell. @param first_part index that the first of out.moments will have.
void shareCell(const BeamGrid& grid, const Patch& cell, const Eigen::Vector3d& center, const NoiseModel& noise,
               const LabelImage& labels, int first_part, std::vector<std::int32_t>& found, CellShares& out) {
  // The usual cases first: one label on all pixels, or none.
  const std::int32_t* corner = labels.labels.data() + grid.index(cell.row_begin, cell.col_begin);
  if (uniform(corner, cell.row_end - cell.row_begin, cell.col_end - cell.col_begin, labels.cols)) {
    if (*corner > 0 && cell.moments.n > 0) addShare(*corner, CellShares::kWhole, out);
    return;
  }
  findLabels(cell, labels, found);
  for (const std::int32_t label : found) {
    if (found.size() == 1 && countPixels(grid, cell, labels, label) == cell.moments.n) {  // the patch's own sums serve
      addShare(label, CellShares::kWhole, out);
      continue;
    }
    const auto chosen = [&](int i, int count) { return labelsAt(labels, i, count) == fillMask(label); };
    BlockSums sums;
    if (!sumPixels(grid, {cell.row_begin, cell.row_end, cell.col_begin, cell.col_end}, chosen, sums)) continue;
    const int n = countLanes(sums.counted);
    const BlockMoments<double> block = momentsOf(sums, center);
    const double sigma = noise.sigma(block.ranges / n) * cell.noise_factor;
    addShare(label, first_part + static_cast<int>(out.moments.size()), out);
    out.moments.push_back(momentsOf(block, n));
    out.moments.back().scale(1.0 / (sigma * sigma));
  }
}

std::int32_t onlyOf(const CellShares& shares, std::size_t first) {
  const std::size_t count = shares.labels.size() - first;
  return count == 1 ? shares.labels[first] : count == 0 ? 0 : -1;
}

void clearCells(CellShares& shares) {
  shares.begin.clear();
  shares.only.clear();
  shares.labels.clear();
  shares.parts.clear();
}

void clear(CellShares& shares) {
  clearCells(shares);
  shares.moments.clear();
  shares.sums.clear();
}

// Adds the shares of cells [begin, end).
void appendCells(const CellShares& from, int begin, int end, CellShares& to) {
  if (begin == end) return;
  const auto append = [](const auto& source, int first, int last, auto& target) {
    target.insert(target.end(), source.begin() + first, source.begin() + last);
  };
  const int first = from.begin[begin], last = from.begin[end];
  const int offset = static_cast<int>(to.labels.size()) - first;
  for (int k = begin; k < end; ++k) to.begin.push_back(from.begin[k] + offset);
  append(from.only, begin, end, to.only);
  append(from.labels, first, last, to.labels);
  append(from.parts, first, last, to.parts);
}

// Adds up the shares of the labels that are chosen.
void sumLabels(const PatchGrid& cells, const std::vector<char>& chosen, CellShares& shares) {
  const int count = static_cast<int>(shares.only.size());
  for (int k = 0; k < count; ++k) {
    for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
      const std::int32_t label = shares.labels[s];
      if (chosen[label] != 0) shares.sums[label] += shares.momentsOf(cells, k, s);
    }
  }
}

// Brings the sums of the labels up to date. @param memory with the shares before; their moments are among those of now.
void updateSums(const PatchGrid& cells, const std::vector<char>& changed, ShareMemory& memory, CellShares& shares) {
  constexpr int kMostLost = 4;  // of a label less than one part in as many remains: rounding would weigh too much
  std::vector<Moments>& sums = shares.sums;
  const CellShares& before = memory.before;
  std::vector<int>& points = memory.points;
  points.resize(sums.size());
  for (std::size_t label = 0; label < sums.size(); ++label) points[label] = sums[label].n;
  for (int k = 0; k < static_cast<int>(changed.size()); ++k) {
    if (changed[k] == 0) continue;
    const int first = before.only.empty() ? 0 : before.begin[k], last = before.only.empty() ? 0 : before.begin[k + 1];
    for (int s = first; s < last; ++s) {
      const bool whole = before.parts[s] == CellShares::kWhole;
      sums[before.labels[s]] -= whole ? cells.patches[k].moments : shares.moments[before.parts[s]];
    }
    for (int s = shares.begin[k]; s < shares.begin[k + 1]; ++s) {
      const auto label = static_cast<std::size_t>(shares.labels[s]);
      if (label >= sums.size()) sums.resize(label + 1);
      sums[label] += shares.momentsOf(cells, k, s);
    }
  }
  std::vector<char>& again = memory.again;
  again.assign(sums.size(), 0);
  bool any = false;
  for (std::size_t label = 0; label < points.size(); ++label) {
    if (sums[label].n >= (points[label] + kMostLost - 1) / kMostLost) continue;
    again[label] = sums[label].n > 0 ? 1 : 0;
    any = any || again[label] != 0;
    sums[label] = Moments();
  }
  if (any) sumLabels(cells, again, shares);
}

}  // namespace

void renameShares(const std::vector<std::int32_t>& names, CellShares& shares) {
  int out = 0;
  for (std::size_t k = 0; k < shares.only.size(); ++k) {
    const int first = out, begin = shares.begin[k], end = shares.begin[k + 1];
    shares.begin[k] = first;
    for (int s = begin; s < end; ++s) {
      const std::int32_t label = names[shares.labels[s]];
      int at = first;
      while (at < out && shares.labels[at] != label) ++at;
      if (at < out) {  // neither is whole
        shares.moments[shares.parts[at]] += shares.moments[shares.parts[s]];
      } else {
        shares.labels[out] = label;
        shares.parts[out++] = shares.parts[s];
      }
    }
    if (end > begin) shares.only[k] = out - first == 1 ? shares.labels[first] : -1;
  }
  for (std::size_t label = 0; label < shares.sums.size(); ++label) {
    if (names[label] == static_cast<std::int32_t>(label)) continue;
    shares.sums[names[label]] += shares.sums[label];
    shares.sums[label] = Moments();
  }
  shares.begin.back() = out;
  shares.labels.resize(static_cast<std::size_t>(out));
  shares.parts.resize(static_cast<std::size_t>(out));
}

CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                      int threads) {
  CellShares shares;
  ShareMemory memory;
  updateShares(grid, cells, noise, labels, std::vector<char>(cells.patches.size(), 1), shares, memory, threads);
  return shares;
}

void shareClusters(const PatchClusters& clusters, CellShares& shares) {
  clear(shares);
  const std::size_t count = clusters.cluster_of.size();
  shares.begin.resize(count + 1);
  shares.only.resize(count);
  shares.labels.resize(count + 1);
  int next = 0;
  for (std::size_t k = 0; k < count; ++k) {  // without branches: clusters have many borders
    const std::int32_t label = clusters.cluster_of[k] + 1;
    shares.begin[k] = next;
    shares.only[k] = shares.labels[next] = label;
    next += label > 0 ? 1 : 0;
  }
  shares.begin[count] = next;
  shares.labels.resize(static_cast<std::size_t>(next));
  shares.parts.assign(shares.labels.size(), CellShares::kWhole);
  shares.sums.emplace_back();
  for (const Cluster& cluster : clusters.clusters) shares.sums.push_back(cluster.moments);
}

void updateShares(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                  const std::vector<char>& changed, CellShares& shares, ShareMemory& memory, int threads) {
  std::swap(shares, memory.before);
  const CellShares& before = memory.before;
  std::swap(shares.moments, memory.before.moments);  // those that are there stay there, new ones follow
  std::swap(shares.sums, memory.before.sums);
  if (shares.sums.empty()) shares.sums.resize(1);
  const auto known = static_cast<int>(shares.moments.size());
  clearCells(shares);
  const int count = static_cast<int>(cells.patches.size()), parts = rangeCount(threads, count);
  memory.parts.resize(static_cast<std::size_t>(parts));
  memory.rest.resize(static_cast<std::size_t>(std::max(0, parts - 1)));
  forEachPart(threads, parts, [&](int part) {
    CellShares& mine = part == 0 ? shares : memory.rest[part - 1];  // the first part's go where all will be
    if (part > 0) clear(mine);
    std::vector<int>& which = memory.parts[part].cells;
    which.clear();
    const int part_end = partBegin(count, parts, part + 1);
    int next = partBegin(count, parts, part);
    for (int k = next; k < part_end; ++k) {
      if (changed[k] != 0) which.push_back(k);
    }
    for (std::size_t j = 0; j < which.size(); ++j) {
      const int k = which[j];
      if (j + kCellsAhead < which.size()) __builtin_prefetch(&cells.patches[which[j + kCellsAhead]]);
      if (j + kBeamsAhead < which.size()) {
        const Patch& cell = cells.patches[which[j + kBeamsAhead]];
        prefetchCell(grid, labels, cell.row_begin, cell.row_end, cell.col_begin);
      }
      appendCells(before, next, k, mine);
      const std::size_t first = mine.labels.size();
      mine.begin.push_back(static_cast<int>(first));
      shareCell(grid, cells.patches[k], cells.center, noise, labels, part == 0 ? 0 : known, memory.parts[part].found, mine);
      mine.only.push_back(onlyOf(mine, first));
      next = k + 1;
    }
    appendCells(before, next, part_end, mine);
    mine.begin.push_back(static_cast<int>(mine.labels.size()));
  });
  for (const CellShares& part : memory.rest) {
    const std::size_t first = shares.parts.size();
    const int offset = static_cast<int>(shares.moments.size()) - known;
    shares.begin.pop_back();
    appendCells(part, 0, static_cast<int>(part.only.size()), shares);
    shares.begin.push_back(static_cast<int>(shares.labels.size()));
    shares.moments.insert(shares.moments.end(), part.moments.begin(), part.moments.end());
    for (std::size_t s = first; s < shares.parts.size(); ++s) shares.parts[s] += shares.parts[s] >= known ? offset : 0;
  }
  updateSums(cells, changed, memory, shares);
}

std::vector<Eigen::Vector3d> labelPlanes(const CellShares& shares) {
  std::vector<Eigen::Vector3d> planes;
  labelPlanes(shares, planes);
  return planes;
}

void labelPlanes(const CellShares& shares, std::vector<Eigen::Vector3d>& planes) {
  planes.clear();
  planes.reserve(shares.sums.size());
  for (const Moments& m : shares.sums) planes.push_back(fitPlane(m).a);
}

}  // namespace ppc
