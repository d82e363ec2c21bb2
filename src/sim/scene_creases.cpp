// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <cmath>

namespace ppc::sim {
namespace {

using Eigen::Vector3d;
constexpr double kFold = 10.0 * M_PI / 180.0;  // a crease of 170 deg between the faces

// A wall between two points of the floor plan, creased into `pieces` (an even number) that lean in and out by half the fold.
void addFoldedWall(SceneBuilder& b, const Vector3d& from, const Vector3d& to, const Vector3d& inward, int pieces,
                   double height) {
  const Vector3d step = (to - from) / pieces;
  const double stand = step.norm() * std::tan(0.5 * kFold);
  Vector3d a = from;
  for (int i = 1; i <= pieces; ++i) {
    const Vector3d end = from + i * step + (i % 2 == 1 ? stand : 0.0) * inward;
    b.scene.addPlane(makeRectangle(a, end - a, {0.0, 0.0, height}));
    a = end;
  }
}

// A slope of 10 deg up to a platform, both with cheeks.
void addRamp(SceneBuilder& b, const Eigen::Isometry3d& pose, double width, double length) {
  const double height = length * std::tan(kFold);
  const Vector3d x = pose.linear().col(0), y = pose.linear().col(1), z = pose.linear().col(2);
  const Vector3d o = pose.translation();
  b.scene.addPlane(makeRectangle(o, length * x + height * z, width * y));
  for (const double side : {0.0, width}) {
    b.scene.addPlane(makePolygon(o + side * y, x, z, {{0.0, 0.0}, {length, 0.0}, {length, height}}));
  }
  b.box(pose * Eigen::Translation3d(length, 0.0, 0.0), {0.8, width, height});
}

}  // namespace

/// Weak edges: walls creased by 170 deg, a gabled ceiling, steps of 3 to 5 cm on floor and walls, a ramp of 10 deg.
Scene makeCreases(std::uint64_t seed) {
  SceneBuilder b(seed);
  const double w = b.random.uniform(5.5, 7.5), d = b.random.uniform(5.0, 6.5), h = b.random.uniform(2.5, 2.9);
  // Walls are drawn too high; the gable cuts them off. Floor and ceiling reach beyond the walls.
  const double high = h + 1.0;
  addFoldedWall(b, {0, 0, 0}, {w, 0, 0}, Vector3d::UnitY(), 2, high);
  addFoldedWall(b, {0, d, 0}, {w, d, 0}, -Vector3d::UnitY(), 2 * b.random.integer(1, 2), high);
  addFoldedWall(b, {w, 0, 0}, {w, d, 0}, -Vector3d::UnitX(), 2, high);
  Surface plain = makeRectangle({0, 0, 0}, {0, d, 0}, {0, 0, high});
  // Wall panels 3 to 5 cm proud: a step in a wall.
  b.panel(plain, {0.4, 0.0}, {0.4 * d, 1.0}, b.random.uniform(0.03, 0.05));
  b.panel(plain, {0.55 * d, 0.6}, {0.9 * d, 2.0}, b.random.uniform(0.03, 0.05));
  b.scene.addPlane(plain);
  b.scene.addPlane(makeRectangle({-1, -1, 0}, {w + 2, 0, 0}, {0, d + 2, 0}));
  const double gable = std::tan(0.5 * kFold) * (0.5 * d + 1.0);
  b.scene.addPlane(makeRectangle({-1, -1, h}, {w + 2, 0, 0}, {0, 0.5 * d + 1.0, gable}));
  b.scene.addPlane(makeRectangle({-1, d + 1, h}, {w + 2, 0, 0}, {0, -0.5 * d - 1.0, gable}));

  const Eigen::Vector2d sensor{b.random.uniform(0.25, 0.4) * w, b.random.uniform(0.25, 0.75) * d};
  b.takePlace(sensor, 0.4);
  Eigen::Vector2d p;
  if (b.findPlace({1.6, 1.4}, {w - 1.6, d - 1.4}, 1.0, p)) {
    const double yaw = b.random.uniform(-M_PI, M_PI);
    addRamp(b,
            Eigen::Translation3d(p.x(), p.y(), 0.0) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) *
                Eigen::Translation3d(-1.1, -0.5, 0.0) * Eigen::Isometry3d::Identity(),
            1.0, b.random.uniform(1.2, 1.6));
  }
  // Platforms of 3 to 5 cm, one upon the other.
  for (int i = b.random.integer(1, 2); i > 0; --i) {
    if (!b.findPlace({1.2, 1.2}, {w - 1.2, d - 1.2}, 0.75, p)) continue;
    const double step = b.random.uniform(0.03, 0.05), yaw = b.random.uniform(-M_PI, M_PI);
    b.standingBox(p.x(), p.y(), 0.0, yaw, {1.5, 1.2, step});
    b.standingBox(p.x(), p.y(), step, yaw, {0.8, 0.7, b.random.uniform(0.03, 0.05)});
  }
  const double height = b.random.uniform(1.1, 1.5);
  return b.finish({sensor.x(), sensor.y(), height}, b.random.uniform(-M_PI, M_PI));
}

}  // namespace ppc::sim
