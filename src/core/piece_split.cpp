// SPDX-License-Identifier: BSD-3-Clause
#include "piece_split.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

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

}  // namespace

std::vector<std::vector<PixelRing>> ringsByComponent(const PixelContours& contours, int min_hole_size) {
  std::vector<std::vector<PixelRing>> pieces(static_cast<std::size_t>(contours.components));
  for (const PixelRing& ring : contours.rings) {  // outer rings come before their holes
    if (!ring.hole || ring.pixels >= min_hole_size) pieces[ring.component].push_back(ring);
  }
  return pieces;
}

PieceMask maskOfPiece(const std::vector<PixelCorner>& corners, const std::vector<PixelRing>& rings) {
  int top = corners[rings.front().begin].row, bottom = top;
  int left = corners[rings.front().begin].col, right = left;
  for (std::size_t i = rings.front().begin; i < rings.front().end; ++i) {
    top = std::min(top, corners[i].row);
    bottom = std::max(bottom, corners[i].row);
    left = std::min(left, corners[i].col);
    right = std::max(right, corners[i].col);
  }
  PieceMask mask{top, left, {bottom - top, right - left, {}}};
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
    for (int c = 1; c < cols; ++c) pixels[r * cols + c] ^= pixels[r * cols + c - 1];
  }
  return mask;
}

bool splitAtFolds(const CornerProjection& projection, PieceMask& mask) {
  const int rows = mask.labels.rows, cols = mask.labels.cols;
  std::vector<int> above(static_cast<std::size_t>(cols) + 1), below(above.size());
  // Folds are long and few: in between two corners of one sign a few columns apart there is none.
  const auto fill = [&](int row, std::vector<int>& signs) {
    const auto sign = [&](int c) { return projection.handedness(mask.row + row, mask.col + c); };
    signs[0] = sign(0);
    for (int from = 0; from < cols;) {
      const int to = std::min(from + kStride, cols);
      signs[to] = sign(to);
      const bool fold = signs[from] != signs[to];
      for (int c = from + 1; c < to; ++c) signs[c] = fold ? sign(c) : signs[to];
      from = to;
    }
  };
  std::vector<std::int32_t> split(mask.labels.labels.size(), 0);
  std::int32_t found = 0;
  fill(0, above);
  for (int r = 0; r < rows; ++r) {
    fill(r + 1, below);
    const std::size_t row = static_cast<std::size_t>(r) * static_cast<std::size_t>(cols);
    found |= splitRow(&mask.labels.labels[row], above.data(), below.data(), cols, &split[row]);
    above.swap(below);
  }
  if (found != 3) return false;
  mask.labels.labels = std::move(split);
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
