// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

namespace ppc::sim {

/// A corridor with doors standing back in both walls, deep recesses, a side passage, notice boards and a cupboard.
Scene makeCorridor(std::uint64_t seed) {
  SceneBuilder b(seed);
  auto room = b.makeRoom({b.random.uniform(8.0, 14.0), b.random.uniform(1.8, 2.6), b.random.uniform(2.4, 2.8)});
  const double length = room.size.x(), width = room.size.y();
  for (const int wall : {0, 2}) {
    Surface& face = room.walls[wall];
    const int slots = static_cast<int>(length / 2.2);
    const double slot = length / slots;
    for (int i = 0; i < slots; ++i) {
      const double u = i * slot + b.random.uniform(0.25, 0.5), door = b.random.uniform(0.85, 1.0);
      switch (b.random.integer(0, 5)) {
        case 0:
        case 1:
        case 2:
          b.recess(face, {u, 0.0}, {u + door, 2.05}, b.random.uniform(0.06, 0.25), -1, room.floor_id);
          break;
        case 3:
          b.recess(face, {u, 0.0}, {u + 1.3 * door, 2.2}, b.random.uniform(0.5, 2.5), -1, room.floor_id);
          break;
        case 4:
          b.panel(face, {u, 1.0}, {u + b.random.uniform(0.8, 1.4), b.random.uniform(1.6, 1.9)}, 0.02);
          break;
        default: {
          const double bottom = b.random.chance(0.5) ? 0.0 : 0.9, depth = b.random.uniform(0.15, 0.3);
          b.panel(face, {u, bottom}, {u + b.random.uniform(0.4, 0.9), b.random.uniform(1.2, 1.8)}, depth);
          break;
        }
      }
    }
  }
  for (const int wall : {1, 3}) {
    const double u = b.random.uniform(0.3, width - 1.3);
    b.recess(room.walls[wall], {u, 0.0}, {u + 1.0, 2.05}, b.random.uniform(0.06, 0.2), -1, room.floor_id);
  }
  b.addRoom(room);
  // A beam across and a lamp under the ceiling.
  b.standingBox(b.random.uniform(0.4, 0.6) * length, 0.5 * width, room.size.z() - 0.2, 0.0, {0.3, width, 0.2});
  const double x = b.random.uniform(1.2, 2.5);
  b.standingBox(x + 1.5, 0.5 * width, room.size.z() - 0.06, 0.0, {1.2, 0.3, 0.06});
  const double yaw = b.random.uniform(-0.3, 0.3);
  return b.finish({x, b.random.uniform(0.4, 0.6) * width, b.random.uniform(1.0, 1.5)}, yaw);
}

}  // namespace ppc::sim
