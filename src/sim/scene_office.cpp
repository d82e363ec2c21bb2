// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <cmath>

namespace ppc::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void addDoor(SceneBuilder& b, SceneBuilder::Room& room, int wall) {
  const double length = room.walls[wall].bounds.max().x();
  const double width = b.random.uniform(0.85, 1.0), height = b.random.uniform(2.0, 2.1);
  const double u = b.random.uniform(0.3, length - width - 0.3);
  // A closed door stands back a little; behind an open one a hallway's far wall is seen.
  const double depth = b.random.chance(0.6) ? b.random.uniform(0.05, 0.12) : b.random.uniform(1.2, 2.0);
  b.recess(room.walls[wall], {u, 0.0}, {u + width, height}, depth, -1, room.floor_id);
}

void addWindows(SceneBuilder& b, SceneBuilder::Room& room, int wall) {
  const double length = room.walls[wall].bounds.max().x();
  const int count = b.random.integer(1, 2);
  const double slot = length / count;
  const double sill = b.random.uniform(0.8, 1.0), top = b.random.uniform(1.9, 2.2);
  for (int i = 0; i < count; ++i) {
    const double width = std::min(slot - 0.8, b.random.uniform(1.0, 1.8));
    const double u = i * slot + 0.5 * (slot - width);
    // Glass gives no return.
    b.recess(room.walls[wall], {u, sill}, {u + width, top}, b.random.uniform(0.1, 0.25), -2, -1);
  }
}

void addDecoratedWall(SceneBuilder& b, SceneBuilder::Room& room, int wall) {
  Surface& face = room.walls[wall];
  const double length = face.bounds.max().x();
  if (b.random.chance(0.5)) {
    const double width = b.random.uniform(0.8, 1.4), u = b.random.uniform(0.3, length - width - 0.3);
    const double v = b.random.uniform(0.9, 1.1);
    const double depth = b.random.uniform(0.15, 0.35);
    b.recess(face, {u, v}, {u + width, v + b.random.uniform(0.7, 1.0)}, depth, -1, -1);
    return;
  }
  const int pictures = b.random.integer(1, 2);
  for (int i = 0; i < pictures; ++i) {
    const double slot = length / pictures, width = std::min(slot - 0.3, b.random.uniform(0.6, 1.4));
    const double u = i * slot + b.random.uniform(0.1, slot - width - 0.1), v = b.random.uniform(1.2, 1.4);
    b.panel(face, {u, v}, {u + width, v + b.random.uniform(0.5, 0.8)}, 0.02);
  }
}

}  // namespace

/// A furnished room: door, windows, pictures or a recess, cupboards and a shelf along the walls, desks and chairs.
Scene makeOffice(std::uint64_t seed) {
  SceneBuilder b(seed);
  auto room = b.makeRoom({b.random.uniform(5.0, 7.5), b.random.uniform(4.5, 6.5), b.random.uniform(2.5, 3.0)});
  const double w = room.size.x(), d = room.size.y();
  const int first = b.random.integer(0, 3);
  addDoor(b, room, first);
  addWindows(b, room, (first + 2) % 4);
  addDecoratedWall(b, room, (first + 1) % 4);
  addDecoratedWall(b, room, (first + 3) % 4);
  b.addRoom(room);

  const Vector2d sensor{b.random.uniform(0.4, 0.6) * w, b.random.uniform(0.4, 0.6) * d};
  b.takePlace(sensor, 0.5);
  // Along the walls without a door or windows.
  for (const int wall : {(first + 1) % 4, (first + 3) % 4}) {
    const Surface& face = room.walls[wall];
    const Vector3d inward = face.normal();
    const double yaw = std::atan2(inward.y(), inward.x()) + M_PI / 2.0;
    const int pieces = b.random.integer(1, 2);
    for (int i = 0; i < pieces; ++i) {
      const Vector3d size{b.random.uniform(0.8, 1.2), b.random.uniform(0.35, 0.55), b.random.uniform(0.7, 1.9)};
      const double slot = face.bounds.max().x() / pieces;
      const Vector3d p = face.pose * Vector3d(i * slot + b.random.uniform(0.6, slot - 0.6), 0.0, 0.5 * size.y() + 0.01);
      if ((p.head<2>() - sensor).norm() < 1.2) continue;
      if (b.random.chance(0.3)) {
        b.shelf(p.x(), p.y(), yaw, size, b.random.integer(3, 5));
      } else {
        b.standingBox(p.x(), p.y(), 0.0, yaw, size);
      }
      b.takePlace(p.head<2>(), 0.6);
    }
  }
  const int desks = b.random.integer(1, 3);
  for (int i = 0; i < desks; ++i) {
    Vector2d p;
    if (!b.findPlace({1.0, 1.0}, {w - 1.0, d - 1.0}, 0.8, p)) continue;
    const double yaw = b.random.uniform(-M_PI, M_PI);
    b.table(p.x(), p.y(), yaw, {b.random.uniform(1.2, 1.6), b.random.uniform(0.7, 0.8), 0.74});
    if (b.random.chance(0.6)) b.standingBox(p.x(), p.y(), 0.74, yaw + b.random.uniform(-0.3, 0.3), {0.5, 0.18, 0.42});
    const double side = yaw + M_PI / 2.0;
    b.chair(p.x() + 0.7 * std::cos(side), p.y() + 0.7 * std::sin(side), side + M_PI);
  }
  Vector2d bin;
  if (b.findPlace({0.4, 0.4}, {w - 0.4, d - 0.4}, 0.25, bin)) b.standingBox(bin.x(), bin.y(), 0.0, 0.4, {0.35, 0.35, 0.5});
  if (b.random.chance(0.5)) {
    // A beam under the ceiling.
    b.standingBox(0.5 * w, b.random.uniform(0.25, 0.75) * d, room.size.z() - 0.25, 0.0, {w, 0.3, 0.25});
  }
  const double height = b.random.uniform(1.0, 1.4);
  return b.finish({sensor.x(), sensor.y(), height}, b.random.uniform(-M_PI, M_PI));
}

}  // namespace ppc::sim
