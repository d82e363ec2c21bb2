// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/labels_around.h"

#include <algorithm>
#include <cstddef>

namespace ppc {

void BlockLabels::list(const PatchGrid& cells, const CellShares& shares) {
  first.resize(cells.patch_of_block.size() + kLanes);  // which are read in whole lanes
  second.assign(first.size(), 0);
  for (std::size_t block = 0; block < cells.patch_of_block.size(); ++block) {
    const int cell = cells.patch_of_block[block];
    const std::int32_t only = shares.only[cell];
    first[block] = only;
    if (only < 0) {
      const std::int32_t* const labels = shares.labels.data() + shares.begin[cell];
      first[block] = labels[0];
      second[block] = shares.begin[cell + 1] - shares.begin[cell] == 2 ? labels[1] : -1 - cell;
    } else if (only == 0 && cells.neighbour_begin[cell] == cells.neighbour_begin[cell + 1]) {
      first[block] = kEmpty;  // cells without points have no neighbours, nor has the only one of a grid
    }
  }
  const std::vector<int>& rows = cells.strip_rows;
  even.assign(rows.size(), 0);
  for (std::size_t s = 2; s + 2 < rows.size(); ++s) {
    even[s] = rows[s - 2] == rows[s] && rows[s - 1] == rows[s] && rows[s + 1] == rows[s] && rows[s + 2] == rows[s] ? 1 : 0;
  }
}

const std::vector<std::int32_t>& LabelsAround::find(int cell) {
  const Patch& patch = cells_.patches[cell];
  const int strip = patch.col_begin / cells_.strip_cols, height = cells_.strip_rows[strip];
  const int first = cells_.strip_begin[strip], count = cells_.strip_begin[strip + 1] - first;
  const int k = patch.row_begin / height;
  found_.clear();
  seen_.clear();
  const bool amid = blocks_.even[strip] != 0 && k >= 2 && k + 2 < count;
  if (!(amid ? lookEvenly(first + k, count) : lookAlongStrips(patch, strip, height))) lookStepByStep(cell);
  sortSeen();
  return found_;
}

// The usual case, amid strips with the same rows. @return whether that tells all: all cells next to it have points.
bool LabelsAround::lookEvenly(int block, int count) {
  constexpr LaneMask kThree = {-1, -1, -1, 0};
  const auto around = [&](const std::vector<std::int32_t>& labels, LaneMask(&out)[4]) {
    const std::int32_t* const own = labels.data() + block;
    out[0] = loadLanes<LaneMask>(own - 2);
    out[1] = loadLanes<LaneMask>(own - count - 1) & kThree;
    out[2] = loadLanes<LaneMask>(own + count - 1) & kThree;
    out[3] = LaneMask{own[2], own[-2 * count], own[2 * count], 0};
  };
  LaneMask firsts[4], seconds[4];
  around(blocks_.first, firsts);
  const LaneMask empty = fillMask(BlockLabels::kEmpty);
  if (anyLane(((firsts[0] == empty) & LaneMask{0, -1, 0, -1}) |
              (((firsts[1] == empty) | (firsts[2] == empty)) & LaneMask{0, -1, 0, 0}))) {
    return false;
  }
  around(blocks_.second, seconds);
  const LaneMask any = (seconds[0] | seconds[1]) | (seconds[2] | seconds[3]);
  seen_.insert(seen_.end(), firsts, firsts + 4);
  if (anyLane(any)) {
    for (const LaneMask second : seconds) lookSecond(second);
  }
  return true;
}

// The same wherever the cell lies.
bool LabelsAround::lookAlongStrips(const Patch& patch, int strip, int height) {
  const int begin = patch.row_begin, end = patch.row_end;
  if (hasEmpty(blocksOver(strip, begin - height, end + height))) return false;
  Stretch own = blocksOver(strip, begin - 2 * height, end + 2 * height);
  for (const int side : {-1, 1}) {
    const int next = strip + side;
    if (next < 0 || next >= cells_.strips()) continue;
    const Stretch touching = blocksOver(next, begin, end);
    if (hasEmpty(touching)) return false;
    const int rows = cells_.strip_rows[next], first = cells_.strip_begin[next];
    const int rows_begin = (touching.begin - first) * rows, rows_end = (touching.end - first) * rows;  // of all these
    // Their neighbours above and below, and what lies beside the cell's own.
    look(blocksOver(next, std::min(rows_begin - rows, begin - height), std::max(rows_end + rows, end + height)));
    look(blocksOver(next + side, rows_begin, rows_end));
    const Stretch back = blocksOver(strip, rows_begin, rows_end);
    own = {std::min(own.begin, back.begin), std::max(own.end, back.end)};
  }
  look(own);
  return true;
}

// Blocks of a strip that overlap some of the rows. Both may lie beyond the image: there are none.
LabelsAround::Stretch LabelsAround::blocksOver(int strip, int row_begin, int row_end) const {
  if (strip < 0 || strip >= cells_.strips()) return {0, 0};
  const int height = cells_.strip_rows[strip], first = cells_.strip_begin[strip];
  return {first + std::max(row_begin, 0) / height, first + (std::min(row_end, cells_.rows) - 1) / height + 1};
}

bool LabelsAround::hasEmpty(Stretch blocks) const {
  std::int32_t least = 0;
  for (int block = blocks.begin; block < blocks.end; ++block) least = std::min(least, blocks_.first[block]);
  return least == BlockLabels::kEmpty;
}

void LabelsAround::look(Stretch blocks) {
  for (int block = blocks.begin; block < blocks.end; block += kLanes) {
    const LaneMask inside = firstLanes(blocks.end - block);
    seen_.push_back(loadLanes<LaneMask>(blocks_.first.data() + block) & inside);
    const LaneMask second = loadLanes<LaneMask>(blocks_.second.data() + block) & inside;
    if (anyLane(second)) lookSecond(second);
  }
}

void LabelsAround::lookSecond(LaneMask labels) {
  seen_.push_back(labels);
  if (!anyLane(labels < LaneMask{})) return;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (labels[lane] < 0) lookAtShares(-1 - labels[lane]);
  }
}

// Finds one label after the other, the lowest first.
void LabelsAround::sortSeen() {
  const auto lower = [](LaneMask a, LaneMask b) { return a < b ? a : b; };
  constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();
  for (LaneMask found = {}; true;) {
    LaneMask next = fillMask(kNone);
    for (const LaneMask labels : seen_) next = lower(next, labels > found ? labels : fillMask(kNone));
    next = lower(next, __builtin_shufflevector(next, next, 2, 3, 0, 1));
    found = lower(next, __builtin_shufflevector(next, next, 1, 0, 3, 2));
    if (found[0] == kNone) return;
    found_.push_back(found[0]);
  }
}

void LabelsAround::lookStepByStep(int cell) {
  lookAtShares(cell);
  cells_.forEachNeighbour(cell, [&](int near) {
    lookAtShares(near);
    cells_.forEachNeighbour(near, [&](int next) { lookAtShares(next); });
  });
}

void LabelsAround::lookAtShares(int cell) {
  const int begin = shares_.begin[cell], end = shares_.begin[cell + 1];
  for (int s = begin; s < end; s += kLanes) seen_.push_back(loadLanes<LaneMask>(shares_.labels.data() + s, end - s));
}

}  // namespace ppc
