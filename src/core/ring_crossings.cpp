// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_crossings.h"

#include "patch_plane_clustering/core/cross_product.h"

#include <algorithm>

namespace ppc {
namespace {

bool near(const Eigen::Vector2d& p, const RingSegment& s) {
  const Eigen::Vector2d edge = s.b - s.a;
  const double length2 = edge.squaredNorm();
  const double along = length2 > 0.0 ? std::clamp((p - s.a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - along * edge).squaredNorm() < kRingClearance * kRingClearance;
}

bool meets(const RingSegment& s, const RingSegment& t) {
  const Eigen::Vector2d u = s.b - s.a, v = t.b - t.a;
  const double t_a = cross(u, t.a - s.a), t_b = cross(u, t.b - s.a);
  const double s_a = cross(v, s.a - t.a), s_b = cross(v, s.b - t.a);
  if (((t_a > 0.0) != (t_b > 0.0)) && ((s_a > 0.0) != (s_b > 0.0))) return true;
  // If two segments do not cross, an end of one of them is nearest to the other.
  return near(s.a, t) || near(s.b, t) || near(t.a, s) || near(t.b, s);
}

void listSegments(const std::vector<Eigen::Vector2d>* rings, std::size_t count, std::vector<RingSegment>& segments) {
  segments.clear();
  for (std::size_t r = 0; r < count; ++r) {
    const auto& ring = rings[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &a = ring[i], &b = ring[i + 1 == ring.size() ? 0 : i + 1];
      const auto [min_x, max_x] = std::minmax(a.x(), b.x());
      const auto [min_y, max_y] = std::minmax(a.y(), b.y());
      const bool bad = ring.size() < 3 || (b - a).squaredNorm() < kRingClearance * kRingClearance;
      segments.push_back({a, b, min_x, max_x, min_y, max_y, {r, i}, bad});
    }
  }
}

// Calls f for every two segments that meet and should not.
template <typename F>
void forEachMeeting(const std::vector<Eigen::Vector2d>* rings, CrossingMemory& memory, F&& f) {
  std::vector<RingSegment>& segments = memory.segments;
  std::vector<std::pair<double, std::size_t>>& order = memory.order;
  order.clear();
  for (std::size_t i = 0; i < segments.size(); ++i) order.emplace_back(segments[i].min_x, i);
  std::sort(order.begin(), order.end());
  std::vector<std::size_t>& active = memory.active;
  active.clear();
  for (const auto& [min_x, current] : order) {
    RingSegment& s = segments[current];
    std::size_t kept = 0;
    for (const std::size_t other : active) {
      RingSegment& t = segments[other];
      if (t.max_x < s.min_x - kRingClearance) continue;  // behind the sweep line
      active[kept++] = other;
      if (t.min_y > s.max_y + kRingClearance || t.max_y < s.min_y - kRingClearance) continue;
      const std::size_t n = rings[s.id.ring].size();
      const bool same = s.id.ring == t.id.ring;
      const bool follows = same && (s.id.edge + 1) % n == t.id.edge;
      const bool precedes = same && (t.id.edge + 1) % n == s.id.edge;
      bool bad = false;
      if (follows || precedes) {
        const RingSegment& first = follows ? s : t;
        const RingSegment& second = follows ? t : s;
        bad = near(first.a, second) || near(second.b, first);
      } else {
        bad = meets(s, t);
      }
      if (bad) f(s, t);
    }
    active.resize(kept);
    active.push_back(current);
  }
}

}  // namespace

std::vector<RingEdge> findCrossings(const std::vector<std::vector<Eigen::Vector2d>>& rings) {
  CrossingMemory memory;
  return findCrossings(rings.data(), rings.size(), memory);
}

const std::vector<RingEdge>& findCrossings(const std::vector<Eigen::Vector2d>* rings, std::size_t count,
                                           CrossingMemory& memory) {
  listSegments(rings, count, memory.segments);
  forEachMeeting(rings, memory, [](RingSegment& s, RingSegment& t) { s.bad = t.bad = true; });
  memory.found.clear();
  for (const RingSegment& s : memory.segments) {
    if (s.bad) memory.found.push_back(s.id);
  }
  return memory.found;
}

const std::vector<EdgePair>& findMeetingEdges(const std::vector<Eigen::Vector2d>& ring, CrossingMemory& memory) {
  listSegments(&ring, 1, memory.segments);
  std::vector<EdgePair>& pairs = memory.pairs;
  pairs.clear();
  forEachMeeting(&ring, memory,
                 [&](const RingSegment& s, const RingSegment& t) { pairs.emplace_back(std::minmax(s.id.edge, t.id.edge)); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

bool isInside(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& ring) {
  bool inside = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Eigen::Vector2d &a = ring[i], &b = ring[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      inside = !inside;
    }
  }
  return inside;
}

}  // namespace ppc
