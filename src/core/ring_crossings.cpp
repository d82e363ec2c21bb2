// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/ring_crossings.h"

#include <algorithm>

namespace ppc {
namespace {

struct Segment {
  Eigen::Vector2d a, b;
  double min_x, max_x, min_y, max_y;
  RingEdge id;
  bool bad;
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool near(const Eigen::Vector2d& p, const Segment& s) {
  const Eigen::Vector2d edge = s.b - s.a;
  const double length2 = edge.squaredNorm();
  const double along = length2 > 0.0 ? std::clamp((p - s.a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - along * edge).squaredNorm() < kRingClearance * kRingClearance;
}

bool meets(const Segment& s, const Segment& t) {
  const Eigen::Vector2d u = s.b - s.a, v = t.b - t.a;
  const double t_a = cross(u, t.a - s.a), t_b = cross(u, t.b - s.a);
  const double s_a = cross(v, s.a - t.a), s_b = cross(v, s.b - t.a);
  if (((t_a > 0.0) != (t_b > 0.0)) && ((s_a > 0.0) != (s_b > 0.0))) return true;
  // If two segments do not cross, an end of one of them is nearest to the other.
  return near(s.a, t) || near(s.b, t) || near(t.a, s) || near(t.b, s);
}

std::vector<Segment> segmentsOf(const std::vector<std::vector<Eigen::Vector2d>>& rings) {
  std::vector<Segment> segments;
  std::size_t count = 0;
  for (const auto& ring : rings) count += ring.size();
  segments.reserve(count);
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const auto& ring = rings[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
      const auto [min_x, max_x] = std::minmax(a.x(), b.x());
      const auto [min_y, max_y] = std::minmax(a.y(), b.y());
      const bool bad = ring.size() < 3 || (b - a).squaredNorm() < kRingClearance * kRingClearance;
      segments.push_back({a, b, min_x, max_x, min_y, max_y, {r, i}, bad});
    }
  }
  return segments;
}

// Calls f for every two segments that meet and should not.
template <typename F>
void forEachMeeting(const std::vector<std::vector<Eigen::Vector2d>>& rings, std::vector<Segment>& segments, F&& f) {
  std::vector<std::size_t> order(segments.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return segments[i].min_x != segments[j].min_x ? segments[i].min_x < segments[j].min_x : i < j;
  });
  std::vector<std::size_t> active;
  for (const std::size_t current : order) {
    Segment& s = segments[current];
    std::size_t kept = 0;
    for (const std::size_t other : active) {
      Segment& t = segments[other];
      if (t.max_x < s.min_x - kRingClearance) continue;  // behind the sweep line
      active[kept++] = other;
      if (t.min_y > s.max_y + kRingClearance || t.max_y < s.min_y - kRingClearance) continue;
      const std::size_t n = rings[s.id.ring].size();
      const bool same = s.id.ring == t.id.ring;
      const bool follows = same && (s.id.edge + 1) % n == t.id.edge;
      const bool precedes = same && (t.id.edge + 1) % n == s.id.edge;
      bool bad = false;
      if (follows || precedes) {
        const Segment& first = follows ? s : t;
        const Segment& second = follows ? t : s;
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
  std::vector<Segment> segments = segmentsOf(rings);
  forEachMeeting(rings, segments, [](Segment& s, Segment& t) { s.bad = t.bad = true; });
  std::vector<RingEdge> found;
  for (const Segment& s : segments) {
    if (s.bad) found.push_back(s.id);
  }
  return found;
}

std::vector<EdgePair> findMeetingEdges(const std::vector<Eigen::Vector2d>& ring) {
  const std::vector<std::vector<Eigen::Vector2d>> rings{ring};
  std::vector<Segment> segments = segmentsOf(rings);
  std::vector<EdgePair> pairs;
  forEachMeeting(rings, segments,
                 [&](const Segment& s, const Segment& t) { pairs.emplace_back(std::minmax(s.id.edge, t.id.edge)); });
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
