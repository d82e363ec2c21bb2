// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_simplification.h"

#include "patch_plane_clustering/core/cross_product.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ppc {
namespace {

template <typename At>
double ringArea(std::size_t n, const At& at) {
  if (n < 3) return 0.0;
  const Eigen::Vector2d& origin = at(0);
  double twice = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) twice += cross(at(i) - origin, at(i + 1) - origin);
  return 0.5 * twice;
}

}  // namespace

double signedArea(const OutlinePoint* points, std::size_t size) {
  return ringArea(size, [&](std::size_t i) -> const Eigen::Vector2d& { return points[i].point; });
}

double signedArea(const std::vector<Eigen::Vector2d>& ring) {
  return ringArea(ring.size(), [&](std::size_t i) -> const Eigen::Vector2d& { return ring[i]; });
}

void SimplifiedRing::setPoints(const OutlinePoint* points, std::size_t size) {
  points_ = points;
  n_ = size;
  excess_.setPoints(points, size);
}

void SimplifiedRing::simplify(const OutlineTolerance& tolerance, SimplificationMemory& memory) {
  excess_.setTolerance(tolerance);
  vertices_.clear();
  if (tolerance.none()) {
    for (std::size_t i = 0; i < n_; ++i) vertices_.push_back({i, points_[i].point, false});
    return;
  }
  chooseCorners(memory);
  memory.sums.setPoints(points_, n_);
  mergeStraightEdges(memory.sums);
  moveOntoLines(memory);
  keepTolerance(memory);
}

void SimplifiedRing::positions(std::vector<Eigen::Vector2d>& out) const {
  out.clear();
  for (const RingVertex& vertex : vertices_) out.push_back(vertex.position);
}

double SimplifiedRing::area() const {
  return ringArea(size(), [&](std::size_t i) -> const Eigen::Vector2d& { return vertices_[i].position; });
}

std::pair<std::size_t, double> SimplifiedRing::farthest(std::size_t edge, double least) const {
  const RingVertex& a = vertices_[edge];
  const RingVertex& b = vertices_[next(edge)];
  return excess_.farthest(a.corner, b.corner > a.corner ? b.corner : b.corner + n_, a.position, b.position, least);
}

void SimplifiedRing::chooseCorners(SimplificationMemory& memory) {
  // A corner that is surely one of the outline's: the farthest from the middle; and the one farthest from it.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n_; ++i) middle += points_[i].point;
  middle /= static_cast<double>(n_);
  const auto farthestFrom = [&](const Eigen::Vector2d& p) {
    std::pair<std::size_t, double> best{0, -1.0};
    for (std::size_t i = 0; i < n_; ++i) {
      const double distance2 = (points_[i].point - p).squaredNorm();
      if (distance2 > best.second) best = {i, distance2};
    }
    return best.first;
  };
  const std::size_t start = farthestFrom(middle);
  const std::size_t opposite = farthestFrom(points_[start].point);
  std::vector<char>& chosen = memory.chosen;
  chosen.assign(n_, 0);
  chosen[start] = chosen[opposite] = 1;
  const auto [low, high] = std::minmax(start, opposite);
  std::vector<std::pair<std::size_t, std::size_t>>& open = memory.open;
  open.assign({{low, high}, {high, low + n_}});
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    if (last - first < 2) continue;
    const auto [k, worst] = excess_.farthest(first, last, points_[first % n_].point, points_[last % n_].point, 1.0);
    if (!(worst > 1.0)) continue;
    chosen[k % n_] = 1;
    open.emplace_back(first, k);
    open.emplace_back(k, last);
  }
  for (std::size_t i = 0; i < n_; ++i) {
    if (chosen[i] != 0) vertices_.push_back({i, points_[i].point, false});
  }
}

// The starting points, and corners that a staircase pushed just beyond the tolerance of a chord, may lie in the middle of a
// straight edge: two edges become one if a single line fits the corners of both.
void SimplifiedRing::mergeStraightEdges(const LineSums& sums) {
  constexpr double kClose = 0.5;  // square of the share of the tolerance: a straight edge's staircase reaches 0.25
  for (std::size_t i = 0; i < vertices_.size() && vertices_.size() > 3;) {
    const std::size_t first = vertices_[i == 0 ? vertices_.size() - 1 : i - 1].corner;
    const std::size_t last = vertices_[next(i)].corner;
    const Line line = sums.fit(first, last);
    const Eigen::Vector2d from = foot(line, points_[first].point), to = foot(line, points_[last].point);
    const bool straight = excess_.at(first, from, to) <= kClose && excess_.at(last, from, to) <= kClose &&
                          excess_.farthest(first, last > first ? last : last + n_, from, to, kClose).second <= kClose;
    if (straight) {
      vertices_.erase(vertices_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

void SimplifiedRing::putBack(RingVertex& vertex) const {
  vertex.position = points_[vertex.corner].point;
  vertex.moved = false;
}

void SimplifiedRing::moveOntoLines(SimplificationMemory& memory) {
  const std::size_t m = vertices_.size();
  if (m < 3) return;
  std::vector<Line>& lines = memory.lines;
  lines.resize(m);
  for (std::size_t i = 0; i < m; ++i) lines[i] = memory.sums.fit(vertices_[i].corner, vertices_[next(i)].corner);
  for (std::size_t i = 0; i < m; ++i) {
    RingVertex& v = vertices_[i];
    const Eigen::Vector2d target = meet(lines[i == 0 ? m - 1 : i - 1], lines[i], v.position);
    if (!(excess_.at(v.corner, target, target) <= 1.0)) continue;
    v.position = target;
    v.moved = true;
  }
}

// Merging and moving may have taken edges too far from the corners in between.
void SimplifiedRing::keepTolerance(SimplificationMemory& memory) {
  std::vector<std::size_t>& far = memory.far;
  do {
    far.clear();
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (farthest(i, 1.0).second > 1.0) far.push_back(i);
    }
  } while (!far.empty() && refine(far, memory));
}

bool SimplifiedRing::refine(const std::vector<std::size_t>& edges, SimplificationMemory& memory) {
  bool closer = false;
  std::vector<RingVertex>& added = memory.added;
  added.clear();
  for (const std::size_t edge : edges) {
    RingVertex& a = vertices_[edge];
    RingVertex& b = vertices_[next(edge)];
    if (a.moved || b.moved) {
      putBack(a);
      putBack(b);
      closer = true;
      continue;
    }
    const std::size_t k = farthest(edge, -1.0).first;
    if (k != a.corner) added.push_back({k % n_, points_[k % n_].point, false});  // else: two neighbouring corners
  }
  if (added.empty()) return closer;
  vertices_.insert(vertices_.end(), added.begin(), added.end());
  std::sort(vertices_.begin(), vertices_.end(),
            [](const RingVertex& a, const RingVertex& b) { return a.corner < b.corner; });
  return true;
}

}  // namespace ppc
