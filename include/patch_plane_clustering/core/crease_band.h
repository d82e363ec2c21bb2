// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/pixel_set.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace ppc {

/// @brief Collects the pixels of two labels on both sides of where they meet: straight away from a meeting, as far as pixels
/// are of either label, and at most `reach`.
class CreaseBand {
 public:
  static constexpr int kMaxReach = 8;

  /// @param reach at most kMaxReach. @param band for pixels of `labels`.
  CreaseBand(const LabelImage& labels, std::int32_t first, std::int32_t second, int reach, PixelSet& band)
      : labels_(labels), first_(fillMask(first)), second_(fillMask(second)), reach_(reach), band_(band) {}

  /// Around a meeting of a pixel with the one before it in its row.
  void addAlongRow(int pixel) {
    const int col = pixel % labels_.cols;
    const std::uint32_t around = ofEither(pixel - kMaxReach, 2 * kMaxReach);
    const int before = __builtin_clz(~(around << (32 - kMaxReach))), after = __builtin_ctz(~(around >> kMaxReach));
    const int left = std::min({before, reach_, col}), right = std::min({after, reach_, labels_.cols - col});
    band_.add(pixel - left, (1U << (left + right)) - 1U);
  }

  /// Around meetings of `count` pixels of a row with those above them.
  void addAlongColumns(int pixel, int count) {
    const int row = pixel / labels_.cols;
    for (; count > 0; pixel += kLabelStep, count -= kLabelStep) {
      const int columns = std::min(count, kLabelStep);
      walk(pixel - labels_.cols, -labels_.cols, std::min(reach_, row), columns);
      walk(pixel, labels_.cols, std::min(reach_, labels_.rows - row), columns);
    }
  }

 private:
  void walk(int pixel, int step, int steps, int columns) {
    std::uint32_t open = (1U << columns) - 1U;
    for (; steps > 0; --steps, pixel += step) {
      open &= ofEither(pixel, columns);
      if (open == 0) return;
      band_.add(pixel, open);
    }
  }

  // Which of at most kLabelStep pixels from i on are of either label; of more of them than `count`, anything.
  std::uint32_t ofEither(int i, int count) const {
    const std::int32_t* const at = labels_.labels.data() + i;
    const int size = static_cast<int>(labels_.labels.size());
    if (i >= 0 && i + kLabelStep <= size) {
      return labelBits([&](int k) {
        const auto label = loadLanes<LaneMask>(at + k);
        return (label == first_) | (label == second_);
      });
    }
    std::uint32_t found = 0;
    for (int k = std::max(0, -i); k < std::min(count, size - i); ++k) {
      found |= at[k] == first_[0] || at[k] == second_[0] ? 1U << k : 0U;
    }
    return found;
  }

  static_assert(2 * kMaxReach == kLabelStep, "a meeting's surroundings in its row are looked at together");

  const LabelImage& labels_;
  LaneMask first_, second_;
  int reach_;
  PixelSet& band_;
};

}  // namespace ppc
