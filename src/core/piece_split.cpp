// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/piece_split.h"

#include "patch_plane_clustering/core/lanes.h"

#include <algorithm>
#include <cstddef>
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

// Which stretches of kStride columns of a row of the mask have pixels.
void findBusy(const std::int32_t* mask, int cols, std::vector<char>& busy) {
  char* out = busy.data();
  int c = 0;
  for (; c + kStride <= cols; c += kStride) {
    *out++ = anyLane(loadLanes<LaneMask>(mask + c) | loadLanes<LaneMask>(mask + c + kLanes)) ? 1 : 0;
  }
  if (c < cols) *out = std::any_of(mask + c, mask + cols, [](std::int32_t inside) { return inside != 0; }) ? 1 : 0;
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
  const int rows = mask.labels.rows, cols = mask.labels.cols;
  std::vector<int>&above = memory.above, &below = memory.below;
  std::vector<char>&busy_above = memory.busy_above, &busy_below = memory.busy_below;
  above.assign(static_cast<std::size_t>(cols) + 1, 0);
  below.assign(above.size(), 0);
  busy_above.assign(static_cast<std::size_t>((cols + kStride - 1) / kStride), 0);
  busy_below.assign(busy_above.size(), 0);
  // Folds are long and few: in between two corners of one sign a few columns apart there is none. Corners of no pixel of the
  // mask do not matter.
  const auto fill = [&](int row, std::vector<int>& signs) {
    const auto sign = [&](int c) { return projection.handedness(mask.row + row, mask.col + c); };
    bool known = false;  // the sign at `from`
    for (int k = 0, from = 0; from < cols; ++k, from += kStride) {
      if ((busy_above[k] | busy_below[k]) == 0) {
        known = false;
        continue;
      }
      const int to = std::min(from + kStride, cols);
      if (!known) signs[from] = sign(from);
      signs[to] = sign(to);
      known = true;
      if (signs[from] == signs[to]) {
        std::fill(signs.begin() + from + 1, signs.begin() + to, signs[to]);
      } else {
        for (int c = from + 1; c < to; ++c) signs[c] = sign(c);
      }
    }
  };
  std::vector<std::int32_t>& split = memory.split;
  split.resize(mask.labels.labels.size());
  std::int32_t found = 0;
  for (int r = 0; r <= rows; ++r) {
    const std::int32_t* const pixels = mask.labels.labels.data() + static_cast<std::ptrdiff_t>(r) * cols;
    busy_above.swap(busy_below);
    if (r < rows) {
      findBusy(pixels, cols, busy_below);
    } else {
      std::fill(busy_below.begin(), busy_below.end(), 0);
    }
    above.swap(below);
    fill(r, below);
    if (r == 0) continue;
    found |= splitRow(pixels - cols, above.data(), below.data(), cols, &split[static_cast<std::size_t>(r - 1) * cols]);
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
