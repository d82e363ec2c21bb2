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
constexpr std::size_t kRoughColumns = 6;
constexpr double kNear2 = 0.25;   // footprints do not count within this share of the squared tolerance in metres
constexpr float kMore = 1e-3F;    // room for rounding: of squares
constexpr double kTiny = 1e-300;  // keeps the excess of a corner on the edge finite: 0

Pair load(const double* from) {
  Pair pair;
  std::memcpy(&pair, from, sizeof pair);
  return pair;
}

Pair both(double value) { return Pair{value, value}; }

// Two numbers of single precision.
Pair loadWide(const float* from) {
  using Half = float __attribute__((vector_size(8)));
  Half half;
  std::memcpy(&half, from, sizeof half);
  return __builtin_convertvector(half, Pair);
}

Lanes absolute(Lanes v) {
  constexpr std::int32_t kAllButSign = std::numeric_limits<std::int32_t>::max();
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(v) & fillMask(kAllButSign));
}

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
  stride_ = size + kLanes - 1;  // lanes may reach beyond the end
  exact_.resize(2 * stride_);
  rough_.resize(kRoughColumns * stride_);
  origin_ = points[0].point;
  double* const exact = exact_.data();
  float* const rough = rough_.data();
  float reach = 0.0F;
  for (std::size_t i = 0; i < stride_; ++i) {
    const OutlinePoint& p = points[i < size ? i : 0];
    const auto x = static_cast<float>(p.point.x() - origin_.x()), y = static_cast<float>(p.point.y() - origin_.y());
    exact[i] = p.point.x();
    exact[i + stride_] = p.point.y();
    rough[i] = x;
    rough[i + stride_] = y;
    rough[i + 2 * stride_] = p.row_step.x();
    rough[i + 3 * stride_] = p.row_step.y();
    rough[i + 4 * stride_] = p.col_step.x();
    rough[i + 5 * stride_] = p.col_step.y();
    reach = std::max({reach, std::abs(x), std::abs(y)});
  }
  reach_ = reach;
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

// What a corner of some excess must exceed.
struct OutlineExcess::Limits {
  float distance2;   // its square, whatever the footprint
  float per_extent;  // the same, times the footprint's extent in the direction of the offset times the distance
  float no_extent2;  // up to here footprints may not count
  float more2;       // what rounding may add to a square, beyond kMore of it
};

OutlineExcess::Limits OutlineExcess::limitsOf(double excess, const RoughEdge& e) const {
  constexpr double kRounding = 1.0 - 1e-6;
  const double root = std::sqrt(std::max(0.0, excess));
  const double near = kRounding * std::sqrt(metres2_) * root - e.error;
  const float more2 = e.error * e.error * (1.0F + 1.0F / kMore);
  return {near > 0.0 ? static_cast<float>(kRounding * near * near) : -1.0F,
          static_cast<float>((1.0 - kMore) * pixels_ * root), (1.0F + kMore) * static_cast<float>(kNear2 * metres2_) + more2,
          more2};
}

// Whether an excess may be larger than that of the limits. The point of the edge that is nearest need not be found exactly:
// any other is farther.
bool OutlineExcess::anyFarther(std::size_t begin, std::size_t count, const RoughEdge& e, const Limits& limits) const {
  const float* at = rough_.data() + begin;
  const Lanes zero{}, one = ::ppc::fill(1.0F);
  for (std::size_t i = 0; i < count; i += kLanes, at += kLanes) {
    const auto column = [&](std::size_t k) { return loadLanes<Lanes>(at + k * stride_); };
    const Lanes x = column(0) - e.x, y = column(1) - e.y;
    Lanes along = (x * e.dx + y * e.dy) * e.inverse_length2;
    along = along > zero ? along : zero;
    along = along < one ? along : one;
    const Lanes away_x = x - along * e.dx, away_y = y - along * e.dy;
    const Lanes distance2 = away_x * away_x + away_y * away_y;
    const LaneMask far = distance2 > ::ppc::fill(limits.distance2);
    if (!anyLane(far)) continue;
    const Lanes row_x = column(2), row_y = column(3), col_x = column(4), col_y = column(5);
    const Lanes extent = absolute(away_x * row_x + away_y * row_y) + absolute(away_x * col_x + away_y * col_y);
    const Lanes sides = absolute(row_x) + absolute(row_y) + absolute(col_x) + absolute(col_y);
    const Lanes most2 = (1.0F + kMore) * distance2 + limits.more2;
    const LaneMask beyond = most2 > limits.per_extent * (extent - 2.0F * e.error * sides);
    if (anyLane(far & (beyond | (distance2 <= ::ppc::fill(limits.no_extent2))))) return true;
  }
  return false;
}

// Writes whole pairs: one more than asked for if `count` is odd.
void OutlineExcess::fill(std::size_t begin, std::size_t count, const Edge& e, double* excess) const {
  const double* const exact = exact_.data() + begin;
  const float* const rough = rough_.data() + begin;
  const Pair zero{}, one = both(1.0), tiny = both(kTiny), metres2 = both(metres2_), pixels = both(pixels_);
  const Pair near2 = both(kNear2 * metres2_), from_x = both(e.x), from_y = both(e.y), dx = both(e.dx), dy = both(e.dy);
  const Pair inverse = both(e.inverse_length2);
  for (std::size_t i = 0; i < count; i += kPair) {
    const auto step = [&](std::size_t column) { return loadWide(rough + column * stride_ + i); };
    const Pair x = load(exact + i) - from_x, y = load(exact + stride_ + i) - from_y;
    const Pair row_x = step(2), row_y = step(3), col_x = step(4), col_y = step(5);
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
  const RoughEdge rough = roughly(edge);
  // A few corners tell what the farthest one has at least.
  double known = least;
  double excess[kBlock];
  constexpr std::size_t kSamples = 8, kLong = 8 * kBlock;
  if (last - first > kLong) {
    constexpr double kBelow = 1.0 - 1e-9;  // it is among those yet to be found
    for (std::size_t sample = 1; sample < kSamples; ++sample) {
      const std::size_t k = first + sample * (last - first) / kSamples;
      fill(k < size_ ? k : k - size_, 1, edge, excess);
      known = std::max(known, kBelow * excess[0]);
    }
  }
  Limits limits = limitsOf(known, rough);
  for (std::size_t k = first + 1; k < last;) {
    const std::size_t begin = k < size_ ? k : k - size_;
    const std::size_t count = std::min({kBlock, last - k, size_ - begin});
    if (anyFarther(begin, count, rough, limits)) {
      fill(begin, count, edge, excess);
      for (std::size_t i = 0; i < count; ++i) {
        if (excess[i] > std::max(worst.second, least)) worst = {k + i, excess[i]};
      }
      if (worst.second > known) {
        known = worst.second;
        limits = limitsOf(known, rough);
      }
    }
    k += count;
  }
  return worst;
}

}  // namespace ppc
