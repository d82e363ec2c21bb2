// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

namespace ppc::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Eigen::Isometry3d placed(double x, double y, double z, double yaw) {
  return Eigen::Translation3d(x, y, z) * Eigen::Isometry3d(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
}

}  // namespace

SceneBuilder::Room SceneBuilder::makeRoom(const Vector3d& size) {
  const double w = size.x(), d = size.y(), h = size.z();
  const Vector3d up(0.0, 0.0, h);
  Room room;
  room.size = size;
  room.walls = {makeRectangle({w, 0, 0}, {-w, 0, 0}, up), makeRectangle({w, d, 0}, {0, -d, 0}, up),
                makeRectangle({0, d, 0}, {w, 0, 0}, up), makeRectangle({0, 0, 0}, {0, d, 0}, up)};
  room.floor = makeRectangle({0, 0, 0}, {w, 0, 0}, {0, d, 0});
  room.ceiling = makeRectangle({0, 0, h}, {0, d, 0}, {w, 0, 0});
  for (int i = 0; i < 4; ++i) room.wall_ids.push_back(scene.newPlane());
  room.floor_id = scene.newPlane();
  return room;
}

void SceneBuilder::addRoom(const Room& room) {
  for (std::size_t i = 0; i < room.walls.size(); ++i) scene.addPlane(room.walls[i], room.wall_ids[i]);
  scene.addPlane(room.floor, room.floor_id);
  scene.addPlane(room.ceiling);
}

void SceneBuilder::recess(Surface& face, const Vector2d& low, const Vector2d& high, double depth, int back_id,
                          int bottom_id) {
  face.holes.push_back(makeRectangularRing(low, high));
  const auto world = [&](double u, double v, double w) -> Vector3d { return face.pose * Vector3d(u, v, w); };
  const auto along = [&](double u, double v, double w) -> Vector3d { return face.pose.linear() * Vector3d(u, v, w); };
  const Vector3d u = along(high.x() - low.x(), 0, 0), v = along(0, high.y() - low.y(), 0), in = along(0, 0, -depth);
  scene.addPlane(makeRectangle(world(low.x(), low.y(), 0), in, v));
  scene.addPlane(makeRectangle(world(high.x(), low.y(), 0), v, in));
  scene.addPlane(makeRectangle(world(low.x(), high.y(), 0), in, u));
  scene.addPlane(makeRectangle(world(low.x(), low.y(), 0), u, in), bottom_id);
  if (back_id != -2) scene.addPlane(makeRectangle(world(low.x(), low.y(), -depth), u, v), back_id);
}

void SceneBuilder::panel(const Surface& face, const Vector2d& low, const Vector2d& high, double thickness) {
  box(face.pose * Eigen::Translation3d(low.x(), low.y(), 0.0), {high.x() - low.x(), high.y() - low.y(), thickness});
}

void SceneBuilder::box(const Eigen::Isometry3d& pose, const Vector3d& s) {
  const Vector3d x = pose.linear().col(0) * s.x(), y = pose.linear().col(1) * s.y(), z = pose.linear().col(2) * s.z();
  const Vector3d low = pose.translation(), high = low + x + y + z;
  scene.addPlane(makeRectangle(low, y, x));
  scene.addPlane(makeRectangle(low, x, z));
  scene.addPlane(makeRectangle(low, z, y));
  scene.addPlane(makeRectangle(high, -x, -y));
  scene.addPlane(makeRectangle(high, -z, -x));
  scene.addPlane(makeRectangle(high, -y, -z));
}

void SceneBuilder::standingBox(double x, double y, double z, double yaw, const Vector3d& size) {
  box(placed(x, y, z, yaw) * Eigen::Translation3d(-0.5 * size.x(), -0.5 * size.y(), 0.0), size);
}

void SceneBuilder::table(double x, double y, double yaw, const Vector3d& size) {
  constexpr double kTop = 0.03, kLeg = 0.05;
  standingBox(x, y, size.z() - kTop, yaw, {size.x(), size.y(), kTop});
  for (const double i : {-1.0, 1.0}) {
    for (const double j : {-1.0, 1.0}) {
      const Vector3d leg = placed(x, y, 0.0, yaw) * Vector3d(i * (0.5 * size.x() - kLeg), j * (0.5 * size.y() - kLeg), 0.0);
      standingBox(leg.x(), leg.y(), 0.0, yaw, {kLeg, kLeg, size.z() - kTop});
    }
  }
}

void SceneBuilder::chair(double x, double y, double yaw) {
  constexpr double kSeat = 0.45;
  table(x, y, yaw, {kSeat, kSeat, 0.46});
  const Vector3d back = placed(x, y, 0.0, yaw) * Vector3d(-0.5 * kSeat + 0.02, 0.0, 0.0);
  standingBox(back.x(), back.y(), 0.46, yaw, {0.03, kSeat, random.uniform(0.4, 0.55)});
}

void SceneBuilder::shelf(double x, double y, double yaw, const Vector3d& s, int boards) {
  constexpr double kBoard = 0.025;
  const Eigen::Isometry3d pose = placed(x, y, 0.0, yaw);
  const auto part = [&](double px, double py, double pz, const Vector3d& size) {
    box(pose * Eigen::Translation3d(px - 0.5 * s.x(), py - 0.5 * s.y(), pz), size);
  };
  part(0, 0, 0, {kBoard, s.y(), s.z()});
  part(s.x() - kBoard, 0, 0, {kBoard, s.y(), s.z()});
  part(kBoard, s.y() - 0.01, 0, {s.x() - 2 * kBoard, 0.01, s.z()});
  for (int i = 0; i < boards; ++i) {
    part(kBoard, 0, i * (s.z() - kBoard) / (boards - 1), {s.x() - 2 * kBoard, s.y() - 0.01, kBoard});
  }
}

void SceneBuilder::plant(double x, double y, double height, int leaves) {
  const double pot = random.uniform(0.12, 0.2), pot_height = 0.3 * height;
  column(x, y, 0.0, pot, pot_height, false);
  const double crown = 0.35 * height;
  for (int i = 0; i < leaves; ++i) {
    Vector3d p, normal;
    do {
      p = Vector3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    } while (p.squaredNorm() > 1.0);
    do {
      normal = Vector3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    } while (normal.squaredNorm() > 1.0 || normal.squaredNorm() < 0.01);
    scene.addPlane(makeDisc(Vector3d(x, y, height - crown) + crown * p, normal, random.uniform(0.02, 0.06)));
  }
}

void SceneBuilder::column(double x, double y, double z, double radius, double height, bool lid) {
  scene.add(makeCylinder({x, y, z}, {0, 0, height}, radius));
  if (lid) scene.addPlane(makeDisc({x, y, z + height}, Vector3d::UnitZ(), radius));
}

bool SceneBuilder::findPlace(const Vector2d& low, const Vector2d& high, double radius, Vector2d& centre) {
  for (int attempt = 0; attempt < 300; ++attempt) {
    centre = Vector2d{random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y())};
    bool free = true;
    for (const Circle& c : taken_) free = free && (c.centre - centre).norm() > c.radius + radius;
    if (!free) continue;
    takePlace(centre, radius);
    return true;
  }
  return false;
}

Scene SceneBuilder::finish(const Vector3d& position, double yaw) {
  scene.tilt_base = placed(position.x(), position.y(), position.z(), yaw);
  scene.build();
  return std::move(scene);
}

}  // namespace ppc::sim
