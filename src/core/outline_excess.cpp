// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/outline_excess.h"

#include "patch_plane_clustering/core/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

constexpr std::size_t kBlock = 8;  // corners that are looked at closely, or not, together
constexpr double kTiny = 1e-300;   // keeps the excess of a corner on the edge finite: 0

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

void OutlineExcess::setPoints(const OutlinePoint* points, std::size_t size) {
  size_ = size;
  stride_ = size + kPair - 1;  // pairs may reach beyond the end
  columns_.resize(6 * stride_);
  for (std::size_t i = 0; i < size; ++i) {
    const OutlinePoint& p = points[i];
    double* out = columns_.data() + i;
    out[0] = p.point.x();
    out[stride_] = p.point.y();
    out[2 * stride_] = p.row_step.x();
    out[3 * stride_] = p.row_step.y();
    out[4 * stride_] = p.col_step.x();
    out[5 * stride_] = p.col_step.y();
  }
  for (std::size_t column = 1; column <= 6; ++column) columns_[column * stride_ - 1] = 0.0;
  const std::size_t rough_stride = stride_ + kLanes;
  rough_.assign(2 * rough_stride, 0.0F);
  origin_ = points[0].point;
  reach_ = 0.0F;
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector2f p = (points[i].point - origin_).cast<float>();
    rough_[i] = p.x();
    rough_[rough_stride + i] = p.y();
    reach_ = std::max({reach_, std::abs(p.x()), std::abs(p.y())});
  }
}

// Distances from it are too small by less than `error`.
struct OutlineExcess::RoughEdge {
  float x, y, dx, dy, inverse_length2;
  float error;
};

OutlineExcess::RoughEdge OutlineExcess::roughly(const Edge& e) const {
  constexpr float kError = 16.0F * std::numeric_limits<float>::epsilon();  // generously, of the largest number
  const auto x = static_cast<float>(e.x - origin_.x()), y = static_cast<float>(e.y - origin_.y());
  const auto dx = static_cast<float>(e.dx), dy = static_cast<float>(e.dy);
  const float largest = std::max({reach_, std::abs(x) + std::abs(dx), std::abs(y) + std::abs(dy)});
  return {x, y, dx, dy, static_cast<float>(e.inverse_length2), kError * largest};
}

// Whether the square of a distance may be larger than this. The point of the edge that is nearest need not be found exactly:
// any other is farther.
bool OutlineExcess::anyFarther(std::size_t begin, std::size_t count, const RoughEdge& e, float distance2) const {
  const float* const x_column = rough_.data() + begin;
  const float* const y_column = x_column + stride_ + kLanes;
  const Lanes zero{}, one = ::ppc::fill(1.0F);
  LaneMask farther{};
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Lanes x = loadLanes<Lanes>(x_column + i) - e.x, y = loadLanes<Lanes>(y_column + i) - e.y;
    Lanes along = (x * e.dx + y * e.dy) * e.inverse_length2;
    along = along > zero ? along : zero;
    along = along < one ? along : one;
    const Lanes away_x = x - along * e.dx, away_y = y - along * e.dy;
    farther |= away_x * away_x + away_y * away_y > ::ppc::fill(distance2);
  }
  return anyLane(farther);
}

// Writes whole pairs: one more than asked for if `count` is odd.
void OutlineExcess::fill(std::size_t begin, std::size_t count, const Edge& e, double* excess) const {
  const double* const columns = columns_.data() + begin;
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
                                                       const Eigen::Vector2d& to, double least) const {
  const Eigen::Vector2d difference = to - from;
  const double length2 = difference.squaredNorm();
  const Edge edge{from.x(), from.y(), difference.x(), difference.y(), length2 > 0.0 ? 1.0 / length2 : 0.0};
  std::pair<std::size_t, double> worst{first, -1.0};
  // Footprints only ever lower the excess: a corner as near as this need not be looked at closely.
  const RoughEdge rough = roughly(edge);
  const auto nearOf = [&](double of_excess) {
    constexpr double kRounding = 1.0 - 1e-6;
    const double near = kRounding * std::sqrt(std::max(0.0, metres2_ * of_excess)) - rough.error;
    return near > 0.0 ? static_cast<float>(kRounding * near * near) : -1.0F;
  };
  float near2 = nearOf(least);
  double excess[kBlock];
  for (std::size_t k = first + 1; k < last;) {
    const std::size_t begin = k < size_ ? k : k - size_;
    const std::size_t count = std::min({kBlock, last - k, size_ - begin});
    if (anyFarther(begin, count, rough, near2)) {
      fill(begin, count, edge, excess);
      for (std::size_t i = 0; i < count; ++i) {
        if (!(excess[i] > std::max(worst.second, least))) continue;
        worst = {k + i, excess[i]};
        near2 = nearOf(excess[i]);
      }
    }
    k += count;
  }
  return worst;
}

}  // namespace ppc
