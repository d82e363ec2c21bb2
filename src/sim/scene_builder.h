// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/sim/random.h"
#include "patch_plane_clustering/sim/scene.h"

#include <vector>

namespace ppc::sim {

/// The parts that rooms are made of. Makers draw at most one random number a call expression: C++ leaves the order of
/// arguments open (that of braced lists is fixed), and the same seed must give the same scene with every compiler. World
/// frame: z up, floor at z = 0 [m].
class SceneBuilder {
 public:
  explicit SceneBuilder(std::uint64_t seed) : random(seed) {}

  Scene scene;
  Random random;

  /// Sides of a rectangular room [0, size.x] x [0, size.y] x [0, size.z], normals inwards. Kept apart from the scene until
  /// addRoom(), so that holes can be cut. Wall coordinates: u to the right-hand rule with v = up, from the floor.
  struct Room {
    Eigen::Vector3d size;
    std::vector<Surface> walls;  ///< y = 0, x = max, y = max, x = 0
    Surface floor, ceiling;
    std::vector<std::int32_t> wall_ids;
    std::int32_t floor_id = 0;
  };
  Room makeRoom(const Eigen::Vector3d& size);
  void addRoom(const Room& room);

  /// Cuts a rectangular hole [low, high] into a face and lines it with a frame of the given depth behind the face.
  /// @param back_id plane that closes the hole at that depth: -1 a fresh one, -2 none (open).
  /// @param bottom_id plane of the lower lining: -1 a fresh one (a sill), or the floor's id (a doorway).
  void recess(Surface& face, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double depth, int back_id,
              int bottom_id);

  /// Flat box that stands off a face by `thickness`: a picture, a notice board, a panel.
  void panel(const Surface& face, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double thickness);

  /// Box [0, size] in `pose`; every face a plane of its own.
  void box(const Eigen::Isometry3d& pose, const Eigen::Vector3d& size);

  /// Box centred over (x, y), turned about z, standing at height z.
  void standingBox(double x, double y, double z, double yaw, const Eigen::Vector3d& size);

  void table(double x, double y, double yaw, const Eigen::Vector3d& size);
  void chair(double x, double y, double yaw);
  void shelf(double x, double y, double yaw, const Eigen::Vector3d& size, int boards);

  /// Pot and a ball of small flat leaves in all directions, each a plane of its own.
  void plant(double x, double y, double height, int leaves);

  /// Cylinder on the floor or on something; its flat lid is a plane if `lid`.
  void column(double x, double y, double z, double radius, double height, bool lid);

  /// Somewhere in [low, high] where a circle of `radius` touches nothing placed so far; the place is then taken.
  /// @return false if none was found.
  bool findPlace(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double radius, Eigen::Vector2d& centre);
  void takePlace(const Eigen::Vector2d& centre, double radius) { taken_.push_back({centre, radius}); }

  /// Puts the tilt base there, looking along yaw, and finishes the scene.
  Scene finish(const Eigen::Vector3d& position, double yaw);

 private:
  struct Circle {
    Eigen::Vector2d centre;
    double radius;
  };
  std::vector<Circle> taken_;
};

Scene makeOffice(std::uint64_t seed);
Scene makeCorridor(std::uint64_t seed);
Scene makeStairs(std::uint64_t seed);
Scene makeCurved(std::uint64_t seed);
Scene makeCreases(std::uint64_t seed);
/// Analytic scenes for tests; false if the name is none of theirs.
bool makeAnalytic(const std::string& name, Scene& scene);

}  // namespace ppc::sim
