// SPDX-License-Identifier: BSD-3-Clause
#include "piece_split.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace ppc {
namespace {

constexpr int kStride = 8;

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
      for (int c = from + 1; c < to; ++c) signs[c] = signs[from] == signs[to] ? signs[to] : sign(c);
      from = to;
    }
  };
  std::vector<std::int32_t> split(mask.labels.labels.size(), 0);
  bool found[2] = {false, false};
  fill(0, above);
  for (int r = 0; r < rows; ++r) {
    fill(r + 1, below);
    for (int c = 0; c < cols; ++c) {
      if (mask.labels.labels[static_cast<std::size_t>(r) * cols + c] == 0) continue;
      const int sum = above[c] + above[c + 1] + below[c] + below[c + 1];
      if (std::abs(sum) != 4) continue;
      split[static_cast<std::size_t>(r) * cols + c] = sum > 0 ? 1 : 2;
      found[sum > 0 ? 0 : 1] = true;
    }
    above.swap(below);
  }
  if (!found[0] || !found[1]) return false;
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
