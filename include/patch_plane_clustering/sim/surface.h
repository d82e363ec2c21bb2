// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace ppc::sim {

/// Closed ring of vertices in a face's own plane [m]; not repeated at the end.
using Ring = std::vector<Eigen::Vector2d>;

/// @brief One surface of a scene, seen from both sides.
struct Surface {
  enum class Kind {
    kFace,      ///< flat polygon with holes in the plane z = 0 of `pose`
    kDisc,      ///< flat disc of `radius` about the origin of `pose`, in its plane z = 0
    kCylinder,  ///< lateral surface about z from z = 0 to z = `length`
    kSphere     ///< about the origin of `pose`
  };
  Kind kind = Kind::kFace;
  std::int32_t plane_id = 0;                                                     ///< ground truth; 0 = belongs to no plane
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();                        ///< own frame in the frame of the scene
  Eigen::AlignedBox2d bounds{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};  ///< of a face [m]
  Ring outline;             ///< of a face; empty: the rectangle `bounds`
  std::vector<Ring> holes;  ///< of a face
  double radius = 0.0;      ///< [m]
  double length = 0.0;      ///< [m]
  double bow =
      0.0;  ///< largest deviation of a face from its plane [m]: a smooth hump along z, nought at the border of `bounds`

  /// Outward in the sense of the right-hand rule: z of `pose`.
  Eigen::Vector3d normal() const { return pose.linear().col(2); }
};

/// @brief Rectangle with one corner at `corner` and edges along u and v (perpendicular, full length) [m]; normal u x v.
Surface makeRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v);

/// @brief Polygon in the plane through `origin` spanned by the directions u and v (perpendicular, any length).
Surface makePolygon(const Eigen::Vector3d& origin, const Eigen::Vector3d& u, const Eigen::Vector3d& v, Ring outline);

/// @brief Disc with the given normal.
Surface makeDisc(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius);

/// @brief Lateral surface of a cylinder from `base` to `base + axis`.
Surface makeCylinder(const Eigen::Vector3d& base, const Eigen::Vector3d& axis, double radius);

Surface makeSphere(const Eigen::Vector3d& centre, double radius);

/// @brief Rectangular hole [low, high] in a face's own coordinates [m]; may touch the border (a door).
Ring makeRectangularRing(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

/// @brief Distance along the ray to the nearest intersection beyond 1e-6 m, or infinity. `direction` is a unit vector.
/// @param normal set to the unit normal there (either side), if hit.
double intersect(const Surface& surface, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 Eigen::Vector3d& normal);

/// @brief Bounding box in the frame of the scene, with room for the bow.
Eigen::AlignedBox3d boundingBox(const Surface& surface);

}  // namespace ppc::sim
