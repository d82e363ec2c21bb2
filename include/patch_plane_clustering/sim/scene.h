// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/sim/surface.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace ppc::sim {

/// @brief What a ray hits first.
struct Hit {
  double range = std::numeric_limits<double>::infinity();  ///< [m]; infinite: nothing
  double cos_incidence = 0.0;                              ///< of the angle between ray and normal, 0..1
  std::int32_t plane_id = 0;                               ///< ground truth; 0 = no plane
};

/// @brief Surfaces around a scanner, each with the identity of the plane that it belongs to.
///
/// A plane id stands for a group of coplanar faces that touch (the wall around a door has one); curved surfaces and clutter
/// have id 0. Ids run from 1. Fill with add(), then call build() before cast(). cast() is thread-safe.
class Scene {
 public:
  /// Where the tilt axis' fixed frame (x forward, z up) stands in the scene.
  Eigen::Isometry3d tilt_base = Eigen::Isometry3d::Identity();

  /// A fresh plane id.
  std::int32_t newPlane() { return ++planes_; }
  std::int32_t planeCount() const { return planes_; }

  /// Adds a surface that belongs to no plane if its id is 0.
  void add(Surface surface) { surfaces_.push_back(std::move(surface)); }

  /// Adds a flat surface with the given plane id, or a fresh one for -1. @return the id.
  std::int32_t addPlane(Surface surface, std::int32_t id = -1);

  const std::vector<Surface>& surfaces() const { return surfaces_; }

  /// Bows every face of at least 1 m either way by `amplitude` [m], half of them inwards; 0 flattens. Call build()
  /// afterwards.
  void bowWalls(double amplitude);

  /// Ideal plane of an id in the frame of the tilt base, normal towards its origin. @throws std::invalid_argument if
  /// unknown.
  Plane planeInBase(std::int32_t id) const;

  /// For every id the first one whose ideal plane is the same; index = id. Where such faces touch, no measurement tells them
  /// apart.
  std::vector<std::int32_t> coplanarIds() const;

  /// Builds the bounding volume hierarchy that cast() needs.
  void build();

  /// Nearest hit of the ray. `direction` is a unit vector; both in the frame of the scene.
  Hit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    int first = 0;  // leaf: first surface in order_; inner node: index of the second child (the first one follows directly)
    int count = 0;  // 0: inner node
  };
  void buildNode(int begin, int end, const std::vector<Eigen::AlignedBox3d>& boxes);

  std::vector<Surface> surfaces_;
  std::vector<Node> nodes_;
  std::vector<int> order_;
  std::int32_t planes_ = 0;
};

/// @brief Names that makeScene() knows: office, corridor, stairs, curved, creases, then analytic ones: wall, box, hole,
/// cylinder, sphere, empty.
const std::vector<std::string>& sceneNames();

/// @brief Makes a scene, built and ready to cast. Same name and seed, same scene.
/// @throws std::invalid_argument listing the known names.
Scene makeScene(const std::string& name, std::uint64_t seed);

}  // namespace ppc::sim
