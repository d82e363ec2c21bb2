// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_labels.h"

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

namespace ppc {
namespace {

// Labels of the strips' patches at one row after the other.
class RowOfPatches {
 public:
  RowOfPatches(const PatchGrid& patches, const CellShares& shares, int row, PatchRow& memory)
      : patches_(patches), shares_(shares), next_(memory.next), end_(memory.end), labels_(memory.labels) {
    next_.resize(patches.strip_rows.size());
    end_.resize(next_.size());
    labels_.resize(next_.size());
    for (std::size_t strip = 0; strip < next_.size(); ++strip) {
      const int height = patches.strip_rows[strip];
      next_[strip] = patches.strip_begin[strip] + row / height;
      end_[strip] = row / height * height;
      take(strip);
    }
  }

  void moveTo(int row) {
    for (std::size_t strip = 0; strip < end_.size(); ++strip) {
      if (end_[strip] == row) take(strip);
    }
  }

  // What the labels of the row's pixels with a measurement are, others get 0.
  void paint(const float* ranges, std::int32_t* out) const {
    const std::int32_t* label = labels_.data();
    const int width = patches_.strip_cols, cols = patches_.cols, whole = width == kLanes ? cols / width * width : 0;
    for (int c = 0; c < whole; c += kLanes) {  // the default
      const LaneMask painted = (loadLanes<Lanes>(ranges + c) > Lanes{}) & fillMask(*label++);
      std::memcpy(out + c, &painted, sizeof painted);
    }
    for (int begin = whole; begin < cols; begin += width, ++label) {
      for (int c = begin; c < std::min(begin + width, cols); ++c) out[c] = ranges[c] > 0.0F ? *label : 0;
    }
  }

 private:
  void take(std::size_t strip) {
    labels_[strip] = shares_.only[patches_.patch_of_block[next_[strip]++]];
    end_[strip] += patches_.strip_rows[strip];
  }

  const PatchGrid& patches_;
  const CellShares& shares_;
  std::vector<int>&next_, &end_;  // see PatchRow
  std::vector<std::int32_t>& labels_;
};

}  // namespace

void patchLabels(const BeamGrid& grid, const PatchGrid& patches, const CellShares& shares, std::vector<PatchRow>& memory,
                 LabelImage& out, int threads) {
  out.rows = grid.rows;
  out.cols = grid.cols;
  out.labels.resize(static_cast<std::size_t>(grid.size()));
  forEachRange(threads, grid.rows, memory, [&](int begin, int end, PatchRow& scratch) {
    RowOfPatches patch_row(patches, shares, begin, scratch);
    for (int row = begin; row < end; ++row) {  // as the memory lies
      patch_row.moveTo(row);
      patch_row.paint(grid.range.data() + grid.index(row, 0), out.labels.data() + grid.index(row, 0));
    }
  });
}

}  // namespace ppc
