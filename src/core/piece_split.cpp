// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/piece_split.h"

#include "patch_plane_clustering/core/lanes.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <numeric>

namespace ppc {
namespace {

constexpr int kStride = 8;

// Pixels of a mask of ones and zeros whose four corners all have the sign + become 1, all - become 2, others 0.
// @return the labels given, or-ed. Without branches, so that it becomes vector code.
std::int32_t splitRow(const std::int32_t* mask, const int* above, const int* below, int cols,
                      std::int32_t* __restrict split) {
  std::int32_t found = 0;
  for (int c = 0; c < cols; ++c) {
    const int sum = above[c] + above[c + 1] + below[c] + below[c + 1];
    split[c] = mask[c] * ((sum == 4 ? 1 : 0) | (sum == -4 ? 2 : 0));
    found |= split[c];
  }
  return found;
}

// Up to kStride pixels of a mask of ones and zeros become `label` where they were 1.
void nameRow(const std::int32_t* mask, int cols, std::int32_t label, std::int32_t* out) {
  if (cols < kStride) {
    for (int c = 0; c < cols; ++c) out[c] = mask[c] * label;
    return;
  }
  for (int c = 0; c < kStride; c += kLanes) {
    const LaneMask named = fillMask(label) & -loadLanes<LaneMask>(mask + c);
    std::memcpy(out + c, &named, sizeof named);
  }
}

// Marks which stretches of kStride columns of a row of the mask have pixels.
void markBusy(const std::int32_t* mask, int cols, char* busy) {
  int c = 0;
  for (; c + kStride <= cols; c += kStride, ++busy) {
    if (anyLane(loadLanes<LaneMask>(mask + c) | loadLanes<LaneMask>(mask + c + kLanes))) *busy = 1;
  }
  if (c < cols && std::any_of(mask + c, mask + cols, [](std::int32_t inside) { return inside != 0; })) *busy = 1;
}

}  // namespace

void ringsByComponent(const PixelContours& contours, int min_hole_size, PixelPieces& out) {
  const auto kept = [&](const PixelRing& ring) { return !ring.hole || ring.pixels >= min_hole_size; };
  std::vector<std::size_t>& next = out.next;
  next.assign(static_cast<std::size_t>(contours.components) + 1, 0);
  for (const PixelRing& ring : contours.rings) next[ring.component + 1] += kept(ring) ? 1 : 0;
  std::partial_sum(next.begin(), next.end(), next.begin());
  out.rings.resize(next.back());
  out.pieces.resize(static_cast<std::size_t>(contours.components));
  for (std::size_t k = 0; k < out.pieces.size(); ++k) {
    out.pieces[k] = {out.rings.data() + next[k], out.rings.data() + next[k + 1]};
  }
  for (const PixelRing& ring : contours.rings) {  // outer rings come before their holes
    if (kept(ring)) out.rings[next[ring.component]++] = ring;
  }
}

void maskPiece(const std::vector<PixelCorner>& corners, const PixelPiece& rings, PieceMask& mask) {
  int top = corners[rings.outer().begin].row, bottom = top;
  int left = corners[rings.outer().begin].col, right = left;
  for (std::size_t i = rings.outer().begin; i < rings.outer().end; ++i) {
    top = std::min(top, corners[i].row);
    bottom = std::max(bottom, corners[i].row);
    left = std::min(left, corners[i].col);
    right = std::max(right, corners[i].col);
  }
  mask.row = top;
  mask.col = left;
  mask.labels.rows = bottom - top;
  mask.labels.cols = right - left;
  mask.labels.labels.assign(static_cast<std::size_t>(mask.labels.rows) * mask.labels.cols, 0);
  std::int32_t* const pixels = mask.labels.labels.data();
  const int cols = mask.labels.cols;
  // Even-odd rule: every upright side switches all pixels to its right.
  for (const PixelRing& ring : rings) {
    for (std::size_t i = ring.begin; i < ring.end; ++i) {
      const PixelCorner& a = corners[i];
      const PixelCorner& b = corners[i + 1 == ring.end ? ring.begin : i + 1];
      if (a.row != b.row && a.col < right) pixels[(std::min(a.row, b.row) - top) * cols + a.col - left] ^= 1;
    }
  }
  for (int r = 0; r < mask.labels.rows; ++r) {
    std::int32_t* const row = pixels + r * cols;
    std::int32_t inside = 0;
    for (int c = 0; c < cols; ++c) row[c] = inside ^= row[c];
  }
}

bool splitAtFolds(const CornerProjection& projection, PieceMask& mask, FoldMemory& memory) {
  const int rows = mask.labels.rows, cols = mask.labels.cols, blocks = (cols + kStride - 1) / kStride;
  const std::int32_t* const pixels = mask.labels.labels.data();
  std::vector<std::int32_t>& split = memory.split;
  split.resize(mask.labels.labels.size());
  const auto sign = [&](int row, int col) { return projection.handedness(mask.row + row, mask.col + col); };
  // Signs of the corners of blocks, above and below a row of them: looked for where they are asked for.
  constexpr int kUnknown = 2;
  std::vector<int>&above = memory.above, &below = memory.below;
  below.assign(static_cast<std::size_t>(blocks) + 1, kUnknown);
  const auto look = [&](std::vector<int>& signs, int row, int block) {
    if (signs[block] == kUnknown) signs[block] = sign(row, std::min(block * kStride, cols));
    return signs[block];
  };
  std::int32_t found = 0;
  for (int top = 0; top < rows; top += kStride) {
    const int bottom = std::min(top + kStride, rows);
    memory.busy.assign(static_cast<std::size_t>(blocks), 0);
    for (int r = top; r < bottom; ++r) markBusy(pixels + static_cast<std::ptrdiff_t>(r) * cols, cols, memory.busy.data());
    above.swap(below);
    below.assign(above.size(), kUnknown);
    for (int k = 0; k < blocks; ++k) {
      const int left = k * kStride, width = std::min(kStride, cols - left);
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(top) * cols + left;
      // Folds are long and few: in between four corners of one sign a few pixels apart there is none. Corners of no pixel of
      // the mask do not matter.
      const bool busy = memory.busy[k] != 0;
      const int one = busy ? look(above, top, k) : 0;
      if (!busy || (look(above, top, k + 1) == one && look(below, bottom, k) == one && look(below, bottom, k + 1) == one)) {
        const std::int32_t label = one > 0 ? 1 : (one < 0 ? 2 : 0);
        found |= label;
        for (int r = top; r < bottom; ++r) {
          const std::ptrdiff_t row = first + static_cast<std::ptrdiff_t>(r - top) * cols;
          nameRow(pixels + row, width, label, split.data() + row);
        }
        continue;
      }
      int signs[2][kStride + 1];
      const auto fill = [&](int row) {
        for (int c = 0; c <= width; ++c) signs[row & 1][c] = sign(row, left + c);
      };
      fill(top);
      for (int r = top; r < bottom; ++r) {
        const std::ptrdiff_t row = first + static_cast<std::ptrdiff_t>(r - top) * cols;
        fill(r + 1);
        found |= splitRow(pixels + row, signs[r & 1], signs[(r + 1) & 1], width, split.data() + row);
      }
    }
  }
  if (found != 3) return false;
  mask.labels.labels.swap(split);
  return true;
}

bool splitInHalf(PieceMask& mask) {
  const int rows = mask.labels.rows, cols = mask.labels.cols;
  if (rows <= 1 && cols <= 1) return false;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      std::int32_t& label = mask.labels.labels[static_cast<std::size_t>(r) * cols + c];
      if (label != 0) label = (cols >= rows ? 2 * c < cols : 2 * r < rows) ? 1 : 2;
    }
  }
  return true;
}

}  // namespace ppc
