// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace ppc::sim {

std::int32_t Scene::addPlane(Surface surface, std::int32_t id) {
  surface.plane_id = id < 0 ? newPlane() : id;
  surfaces_.push_back(std::move(surface));
  return surfaces_.back().plane_id;
}

void Scene::bowWalls(double amplitude) {
  double sign = 1.0;
  for (Surface& s : surfaces_) {
    if (s.kind != Surface::Kind::kFace || s.bounds.sizes().minCoeff() < 1.0) continue;
    s.bow = sign * amplitude;
    sign = -sign;
  }
}

Plane Scene::planeInBase(std::int32_t id) const {
  for (const Surface& s : surfaces_) {
    if (s.plane_id != id || id == 0) continue;
    Plane plane;
    plane.normal = tilt_base.linear().transpose() * s.normal();
    plane.d = s.normal().dot(s.pose.translation() - tilt_base.translation());
    if (plane.d > 0.0) {
      plane.normal = -plane.normal;
      plane.d = -plane.d;
    }
    return plane;
  }
  throw std::invalid_argument("scene has no plane " + std::to_string(id) + ", allowed: 1 to " + std::to_string(planes_));
}

std::vector<std::int32_t> Scene::coplanarIds() const {
  constexpr double kRounding = 1e-9;  // of normals, and of distances [m]
  std::vector<std::int32_t> first(static_cast<std::size_t>(planes_) + 1, 0);
  std::map<std::int32_t, Plane> planes;
  for (const Surface& s : surfaces_) {
    if (s.plane_id != 0 && planes.count(s.plane_id) == 0) planes[s.plane_id] = planeInBase(s.plane_id);
  }
  for (const auto& [id, plane] : planes) {
    const auto same = [&plane = plane](const std::pair<const std::int32_t, Plane>& other) {
      return (other.second.normal - plane.normal).norm() < kRounding && std::abs(other.second.d - plane.d) < kRounding;
    };
    first[id] = std::find_if(planes.begin(), planes.end(), same)->first;
  }
  return first;
}

void Scene::build() {
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(surfaces_.size());
  for (const Surface& s : surfaces_) boxes.push_back(boundingBox(s));
  order_.resize(surfaces_.size());
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.clear();
  if (!order_.empty()) buildNode(0, static_cast<int>(order_.size()), boxes);
}

// Median split of the widest axis of the centres: simple, and good enough for some hundred surfaces.
void Scene::buildNode(int begin, int end, const std::vector<Eigen::AlignedBox3d>& boxes) {
  const int self = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, centres;
  for (int i = begin; i < end; ++i) {
    box.extend(boxes[order_[i]]);
    centres.extend(boxes[order_[i]].center());
  }
  nodes_[self].low = box.min();
  nodes_[self].high = box.max();
  if (end - begin <= 2) {
    nodes_[self].first = begin;
    nodes_[self].count = end - begin;
    return;
  }
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::stable_sort(order_.begin() + begin, order_.begin() + end,
                   [&](int a, int b) { return boxes[a].center()[axis] < boxes[b].center()[axis]; });
  buildNode(begin, middle, boxes);
  nodes_[self].first = static_cast<int>(nodes_.size());
  buildNode(middle, end, boxes);
}

Hit Scene::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  Hit hit;
  if (nodes_.empty()) return hit;
  const Eigen::Array3d inverse = direction.array().inverse();
  int stack[64];
  int depth = 0;
  stack[depth++] = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  while (depth > 0) {
    const int index = stack[--depth];
    const Node& node = nodes_[index];
    const Eigen::Array3d a = (node.low - origin).array() * inverse;
    const Eigen::Array3d b = (node.high - origin).array() * inverse;
    const double enter = a.min(b).maxCoeff();
    const double leave = a.max(b).minCoeff();
    if (enter > leave || leave < 0.0 || enter > hit.range) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = index + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Surface& s = surfaces_[order_[i]];
      const double t = intersect(s, origin, direction, normal);
      if (t < hit.range) {
        hit.range = t;
        hit.cos_incidence = std::abs(normal.dot(direction));
        hit.plane_id = s.plane_id;
      }
    }
  }
  return hit;
}

}  // namespace ppc::sim
