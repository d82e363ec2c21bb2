// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

namespace ppc::sim {

/// Steps up ahead between two walls, with a landing above, a door behind, a handrail (a cylinder) and a notice board.
Scene makeStairs(std::uint64_t seed) {
  SceneBuilder b(seed);
  const double start = b.random.uniform(2.6, 3.6), landing = b.random.uniform(1.2, 2.0);
  const double tread = b.random.uniform(0.27, 0.32), rise = b.random.uniform(0.15, 0.18);
  const int steps = b.random.integer(7, 10);
  const double end = start + steps * tread;
  auto room = b.makeRoom({end + landing, b.random.uniform(2.2, 3.4), steps * rise + b.random.uniform(2.3, 2.7)});
  const double width = room.size.y();
  const double door = b.random.uniform(0.3, width - 1.3);
  b.recess(room.walls[3], {door, 0.0}, {door + 1.0, 2.05}, b.random.uniform(0.06, 0.15), -1, room.floor_id);
  const double top = b.random.uniform(0.3, width - 1.3);
  b.recess(room.walls[1], {top, steps * rise}, {top + 1.0, steps * rise + 2.05}, b.random.uniform(0.06, 0.15), -1, -1);
  b.panel(room.walls[0], {room.size.x() - start + 0.5, 1.1}, {room.size.x() - start + 1.6, 1.8}, 0.02);
  b.addRoom(room);
  // An open staircase leaves a gap to one wall, closed by a cheek.
  const double gap = b.random.chance(0.5) ? 0.0 : b.random.uniform(0.3, 0.7);
  const double w = width - gap;
  for (int i = 0; i < steps; ++i) {
    const double x = start + i * tread, z = i * rise;
    b.scene.addPlane(makeRectangle({x, w, z}, {0, -w, 0}, {0, 0, rise}));
    const double depth = i + 1 < steps ? tread : tread + landing;
    b.scene.addPlane(makeRectangle({x, 0, z + rise}, {depth, 0, 0}, {0, w, 0}));
  }
  if (gap > 0.0) {
    Ring cheek{{0.0, 0.0}};
    for (int i = 0; i < steps; ++i) {
      cheek.emplace_back(i * tread, (i + 1) * rise);
      cheek.emplace_back((i + 1) * tread, (i + 1) * rise);
    }
    cheek.emplace_back(steps * tread + landing, steps * rise);
    cheek.emplace_back(steps * tread + landing, 0.0);
    b.scene.addPlane(makePolygon({start, w, 0.0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), cheek));
  }
  b.scene.add(makeCylinder({start, 0.08, 0.9}, {steps * tread, 0.0, steps * rise}, 0.025));
  const double yaw = b.random.uniform(-0.2, 0.2);
  return b.finish({b.random.uniform(0.9, 1.4), b.random.uniform(0.4, 0.6) * width, b.random.uniform(1.1, 1.7)}, yaw);
}

}  // namespace ppc::sim
