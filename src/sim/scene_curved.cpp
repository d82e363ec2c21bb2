// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

namespace ppc::sim {

/// A room with columns, barrels, balls, plants, a person-like figure and a rounded corner among a few boxes.
Scene makeCurved(std::uint64_t seed) {
  using Eigen::Vector2d;
  SceneBuilder b(seed);
  auto room = b.makeRoom({b.random.uniform(5.5, 8.0), b.random.uniform(5.0, 7.0), b.random.uniform(2.5, 3.2)});
  const double w = room.size.x(), d = room.size.y(), h = room.size.z();
  const double door = b.random.uniform(0.4, w - 1.4);
  b.recess(room.walls[0], {door, 0.0}, {door + 0.9, 2.05}, 0.1, -1, room.floor_id);
  b.panel(room.walls[2], {1.0, 1.2}, {2.2, 1.9}, 0.02);
  b.addRoom(room);
  const Vector2d sensor{b.random.uniform(0.4, 0.6) * w, b.random.uniform(0.4, 0.6) * d};
  b.takePlace(sensor, 0.6);

  // A big round pillar in a corner of the room.
  const double corner = b.random.uniform(0.7, 1.2);
  const Vector2d at{b.random.chance(0.5) ? 0.0 : w, b.random.chance(0.5) ? 0.0 : d};
  b.column(at.x(), at.y(), 0.0, corner, h, false);
  b.takePlace(at, corner);

  const Vector2d low(0.6, 0.6), high(w - 0.6, d - 0.6);
  Vector2d p;
  for (int i = b.random.integer(1, 3); i > 0; --i) {
    const double radius = b.random.uniform(0.15, 0.4);
    if (b.findPlace(low, high, radius + 0.1, p)) b.column(p.x(), p.y(), 0.0, radius, h, false);
  }
  for (int i = b.random.integer(1, 2); i > 0; --i) {
    const double radius = b.random.uniform(0.25, 0.4);
    if (b.findPlace(low, high, radius + 0.1, p)) b.column(p.x(), p.y(), 0.0, radius, b.random.uniform(0.6, 1.0), true);
  }
  for (int i = b.random.integer(1, 3); i > 0; --i) {
    const double radius = b.random.uniform(0.2, 0.5);
    if (b.findPlace(low, high, radius + 0.1, p)) b.scene.add(makeSphere({p.x(), p.y(), radius}, radius));
  }
  for (int i = b.random.integer(1, 2); i > 0; --i) {
    const double height = b.random.uniform(0.9, 1.7);
    if (b.findPlace(low, high, 0.4 * height, p)) b.plant(p.x(), p.y(), height, b.random.integer(120, 220));
  }
  if (b.findPlace(low, high, 0.35, p)) {
    // A person: trunk, head and legs.
    b.column(p.x(), p.y(), 0.85, 0.18, 0.6, false);
    b.scene.add(makeSphere({p.x(), p.y(), 1.6}, 0.12));
    for (const double side : {-0.1, 0.1}) b.column(p.x() + side, p.y(), 0.0, 0.07, 0.85, false);
  }
  for (int i = b.random.integer(2, 3); i > 0; --i) {
    if (!b.findPlace(low, high, 0.55, p)) continue;
    const double yaw = b.random.uniform(-M_PI, M_PI);
    b.standingBox(p.x(), p.y(), 0.0, yaw,
                  {b.random.uniform(0.5, 0.9), b.random.uniform(0.4, 0.7), b.random.uniform(0.5, 1.2)});
  }
  // A pipe under the ceiling.
  const double pipe = b.random.uniform(0.05, 0.15);
  b.scene.add(makeCylinder({0.0, b.random.uniform(0.2, 0.8) * d, h - 0.2}, {w, 0.0, 0.0}, pipe));
  const double height = b.random.uniform(1.0, 1.4);
  return b.finish({sensor.x(), sensor.y(), height}, b.random.uniform(-M_PI, M_PI));
}

}  // namespace ppc::sim
