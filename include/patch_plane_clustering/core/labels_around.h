// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/cell_shares.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/patch_grid.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace ppc {

/// @brief Labels of cells in the order of their blocks, where cells above each other lie side by side.
struct BlockLabels {
  static constexpr std::int32_t kEmpty = std::numeric_limits<std::int32_t>::min();

  std::vector<std::int32_t> first;   ///< of every block: a label, 0 if it has none, kEmpty if it has no points either
  std::vector<std::int32_t> second;  ///< the other one of two, 0 if there is none; of more than two: -1 - cell
  std::vector<char> even;            ///< for every strip: whether it and two on both sides are there and have the same rows

  /// Lists those of a grid. @param cells all blocks of which have a cell. @param shares of the cells.
  void list(const PatchGrid& cells, const CellShares& shares);
};

/// @brief Working memory of one search after the other for labels around cells.
struct AroundMemory {
  std::vector<LaneMask> seen;  ///< labels, and what is none
  std::vector<std::int32_t> found;
};

/// @brief Finds the labels of the cells within two steps of a cell. A step leads to a cell that shares an edge; from cells
/// without points none leads on. Not thread-safe; the arguments must outlive the object, unchanged.
///
/// Cells within reach are a stretch of blocks in each of five strips, so that few cache lines are read; and no branch
/// depends on what labels they have, which nothing foresees at a border.
class LabelsAround {
 public:
  /// @param memory overwritten.
  LabelsAround(const PatchGrid& cells, const CellShares& shares, const BlockLabels& blocks, AroundMemory& memory)
      : cells_(cells), shares_(shares), blocks_(blocks), seen_(memory.seen), found_(memory.found) {}

  /// @param cell one with points. @return the labels, its own among them, in ascending order; until the next call.
  const std::vector<std::int32_t>& find(int cell);

 private:
  struct Stretch {  // of blocks
    int begin, end;
  };

  bool lookEvenly(int block, int count);
  bool lookAlongStrips(const Patch& patch, int strip, int height);
  void look(Stretch blocks);
  void lookSecond(LaneMask labels);
  Stretch blocksOver(int strip, int row_begin, int row_end) const;
  bool hasEmpty(Stretch blocks) const;
  void sortSeen();
  void lookStepByStep(int cell);
  void lookAtShares(int cell);

  const PatchGrid& cells_;
  const CellShares& shares_;
  const BlockLabels& blocks_;
  std::vector<LaneMask>& seen_;
  std::vector<std::int32_t>& found_;
};

}  // namespace ppc
