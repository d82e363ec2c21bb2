// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/outline_excess.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

// Two corners at a time, in the vector registers that every x86-64 and arm64 processor has.
using Pair = double __attribute__((vector_size(16)));
constexpr std::size_t kPair = 2;
constexpr std::size_t kBlock = 64;
constexpr double kTiny = 1e-300;  // keeps the excess of a corner on the edge finite: 0

Pair load(const double* from) {
  Pair pair;
  std::memcpy(&pair, from, sizeof pair);
  return pair;
}

Pair both(double value) { return Pair{value, value}; }

Pair absolute(Pair v) {
  using Bits = std::int64_t __attribute__((vector_size(16)));
  constexpr std::int64_t kAllButSign = std::numeric_limits<std::int64_t>::max();
  return reinterpret_cast<Pair>(reinterpret_cast<Bits>(v) & Bits{kAllButSign, kAllButSign});
}

Pair larger(Pair a, Pair b) { return a > b ? a : b; }

}  // namespace

struct OutlineExcess::Edge {
  double x, y;  // where it starts
  double dx, dy;
  double inverse_length2;
};

OutlineExcess::OutlineExcess(const OutlinePoint* points, std::size_t size, const OutlineTolerance& tolerance)
    : size_(size),
      stride_(size + kPair - 1),  // pairs may reach beyond the end
      metres2_(tolerance.metres * tolerance.metres),
      pixels_(tolerance.pixels),
      columns_(new double[6 * stride_]) {
  for (std::size_t i = 0; i < size; ++i) {
    const OutlinePoint& p = points[i];
    double* out = columns_.get() + i;
    for (const double value : {p.point.x(), p.point.y(), p.row_step.x(), p.row_step.y(), p.col_step.x(), p.col_step.y()}) {
      *out = value;
      out += stride_;
    }
  }
  for (std::size_t column = 1; column <= 6; ++column) {
    columns_[column * stride_ - 1] = 0.0;
  }
}

// Writes whole pairs: one more than asked for if `count` is odd.
void OutlineExcess::fill(std::size_t begin, std::size_t count, const Edge& e, double* excess) const {
  const double* const columns = columns_.get() + begin;
  const Pair zero{}, one = both(1.0), tiny = both(kTiny), metres2 = both(metres2_), pixels = both(pixels_);
  const Pair near2 = both(0.25 * metres2_), from_x = both(e.x), from_y = both(e.y), dx = both(e.dx), dy = both(e.dy);
  const Pair inverse = both(e.inverse_length2);
  for (std::size_t i = 0; i < count; i += kPair) {
    const double* at = columns + i;
    const Pair x = load(at) - from_x, y = load(at += stride_) - from_y;
    const Pair row_x = load(at += stride_), row_y = load(at += stride_);
    const Pair col_x = load(at += stride_), col_y = load(at + stride_);
    Pair along = (x * dx + y * dy) * inverse;
    along = along > zero ? along : zero;
    along = along < one ? along : one;
    const Pair away_x = x - along * dx, away_y = y - along * dy;
    const Pair distance2 = away_x * away_x + away_y * away_y;
    // The footprint's extent in the direction of the offset, times the distance.
    const Pair extent = pixels * (absolute(away_x * row_x + away_y * row_y) + absolute(away_x * col_x + away_y * col_y));
    const Pair extent2 = distance2 > near2 ? extent * extent : zero;
    const Pair result = distance2 * distance2 / larger(larger(metres2 * distance2, extent2), tiny);
    std::memcpy(excess + i, &result, sizeof result);
  }
}

double OutlineExcess::at(std::size_t corner, const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const Eigen::Vector2d edge = to - from;
  const double length2 = edge.squaredNorm();
  double excess[kPair];
  fill(corner, 1, {from.x(), from.y(), edge.x(), edge.y(), length2 > 0.0 ? 1.0 / length2 : 0.0}, excess);
  return excess[0];
}

std::pair<std::size_t, double> OutlineExcess::farthest(std::size_t first, std::size_t last, const Eigen::Vector2d& from,
                                                       const Eigen::Vector2d& to) const {
  const Eigen::Vector2d difference = to - from;
  const double length2 = difference.squaredNorm();
  const Edge edge{from.x(), from.y(), difference.x(), difference.y(), length2 > 0.0 ? 1.0 / length2 : 0.0};
  std::pair<std::size_t, double> worst{first, -1.0};
  double excess[kBlock];
  for (std::size_t k = first + 1; k < last;) {
    const std::size_t begin = k < size_ ? k : k - size_;
    const std::size_t count = std::min({kBlock, last - k, size_ - begin});
    fill(begin, count, edge, excess);
    for (std::size_t i = 0; i < count; ++i) {
      if (excess[i] > worst.second) worst = {k + i, excess[i]};
    }
    k += count;
  }
  return worst;
}

}  // namespace ppc
