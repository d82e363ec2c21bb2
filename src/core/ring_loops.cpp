// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_loops.h"

#include "patch_plane_clustering/core/cross_product.h"
#include "patch_plane_clustering/core/ring_crossings.h"
#include "patch_plane_clustering/core/ring_simplification.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

// Each takes at least one corner away; a ring that is not free of loops by then is no outline.
constexpr int kPasses = 64;

double areaOf(const std::vector<OutlinePoint>& ring, const RingLoop& loop, std::vector<OutlinePoint>& corners) {
  corners.clear();
  for (std::size_t i = 0; i < loop.count; ++i) corners.push_back(ring[(loop.begin + i) % ring.size()]);
  return std::abs(signedArea(corners.data(), corners.size()));
}

}  // namespace

void dropRepeats(std::vector<OutlinePoint>& ring) {
  const auto apart = [](const OutlinePoint& a, const OutlinePoint& b) {
    return (a.point - b.point).squaredNorm() > 4.0 * kRingClearance * kRingClearance;
  };
  std::size_t kept = std::min<std::size_t>(1, ring.size());
  while (kept < ring.size() && apart(ring[kept - 1], ring[kept])) ++kept;  // these stay where they are
  for (std::size_t i = kept; i < ring.size(); ++i) {
    if (apart(ring[kept - 1], ring[i])) ring[kept++] = ring[i];
  }
  while (kept > 1 && !apart(ring[kept - 1], ring.front())) --kept;
  ring.resize(kept);
}

bool foldsOver(const std::vector<OutlinePoint>& ring, double share) {
  const std::size_t n = ring.size();
  const auto right = [](const OutlinePoint& p) { return p.row_step.x() * p.col_step.y() > p.row_step.y() * p.col_step.x(); };
  std::size_t first = 1;
  while (first < n && right(ring[first]) == right(ring[0])) ++first;
  if (first >= n) return false;
  // Twice the areas of stretches of one handedness, each closed by its chord, and of the whole ring.
  const Eigen::Vector2d& origin = ring[first].point;
  const auto twice = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return cross(p - origin, q - origin); };
  double of_side[2] = {0.0, 0.0}, whole = 0.0;
  std::size_t begin = first;
  for (std::size_t k = 0, i = first; k < n; ++k) {
    const std::size_t next = i + 1 == n ? 0 : i + 1;
    const double area = twice(ring[i].point, ring[next].point);
    const bool side = right(ring[i]);
    whole += area;
    if (right(ring[next]) == side) {
      of_side[side ? 1 : 0] += area;
    } else {
      of_side[side ? 1 : 0] += twice(ring[i].point, ring[begin].point);
      begin = next;
    }
    i = next;
  }
  const double less = std::min(std::abs(of_side[0]), std::abs(of_side[1]));
  const double more = std::max(std::abs(of_side[0]), std::abs(of_side[1]));
  return of_side[0] * of_side[1] < 0.0 && less > share * more && std::abs(whole - of_side[0] - of_side[1]) < 0.1 * less;
}

bool cutLoops(std::vector<OutlinePoint>& ring, double max_area, LoopMemory& memory) {
  std::vector<Eigen::Vector2d>& positions = memory.positions;
  std::vector<RingLoop>& loops = memory.loops;
  std::vector<char>&touched = memory.touched, &gone = memory.gone;
  std::vector<OutlinePoint>& kept = memory.kept;
  bool cut = false;
  for (int pass = 0; pass < kPasses && ring.size() > 3; ++pass) {
    const std::size_t n = ring.size();
    positions.clear();
    for (const OutlinePoint& p : ring) positions.push_back(p.point);
    // Where edges i and j meet, the ring consists of two loops: the corners after i up to j, and the others. The shorter one
    // goes; shortest first, and never two that share corners.
    loops.clear();
    for (const auto& [i, j] : findMeetingEdges(positions, memory.crossings)) {
      const std::size_t between = j - i;
      const bool shorter = 2 * between <= n;
      loops.push_back({shorter ? i + 1 : (j + 1) % n, shorter ? between : n - between, loops.size()});
    }
    std::sort(loops.begin(), loops.end(), [](const RingLoop& a, const RingLoop& b) {
      return a.count != b.count ? a.count < b.count : a.place < b.place;
    });
    touched.assign(n, 0);
    gone.assign(n, 0);
    bool changed = false;
    for (const RingLoop& loop : loops) {
      bool free = true;
      for (std::size_t i = 0; free && i < loop.count; ++i) free = touched[(loop.begin + i) % n] == 0;
      if (!free || n - loop.count < 3 || areaOf(ring, loop, memory.corners) > max_area) continue;
      for (std::size_t i = 0; i < loop.count; ++i) gone[(loop.begin + i) % n] = touched[(loop.begin + i) % n] = 1;
      touched[(loop.begin + n - 1) % n] = touched[(loop.begin + loop.count) % n] = 1;  // the ends of the new edge stay
      changed = true;
    }
    if (!changed) break;
    kept.clear();
    for (std::size_t i = 0; i < n; ++i) {
      if (gone[i] == 0) kept.push_back(ring[i]);
    }
    dropRepeats(kept);
    if (kept.size() < 3) break;
    ring.swap(kept);
    cut = true;
  }
  return cut;
}

}  // namespace ppc
