// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <stdexcept>

namespace ppc::sim {

bool makeAnalytic(const std::string& name, Scene& scene) {
  SceneBuilder builder(0);
  if (name == "wall") {
    // x = 3 m, 20 m either way.
    builder.scene.addPlane(makeRectangle({3, 10, -10}, {0, -20, 0}, {0, 0, 20}));
  } else if (name == "box") {
    // 6 x 4 x 3 m about the origin.
    builder.box(Eigen::Isometry3d(Eigen::Translation3d(-3, -2, -1.5)), {6, 4, 3});
  } else if (name == "hole") {
    // x = 2 m with a hole of 0.8 x 0.6 m straight ahead, and a wall 1 m behind it.
    Surface front = makeRectangle({2, 5, -5}, {0, -10, 0}, {0, 0, 10});
    front.holes.push_back(makeRectangularRing({4.6, 4.7}, {5.4, 5.3}));
    builder.scene.addPlane(front);
    builder.scene.addPlane(makeRectangle({3, 5, -5}, {0, -10, 0}, {0, 0, 10}));
  } else if (name == "cylinder") {
    // Column of radius 0.5 m standing 2 m ahead.
    builder.scene.add(makeCylinder({2, 0, -2}, {0, 0, 4}, 0.5));
  } else if (name == "sphere") {
    builder.scene.add(makeSphere({2, 0, 0}, 0.5));
  } else if (name != "empty") {
    return false;
  }
  scene = builder.finish(Eigen::Vector3d::Zero(), 0.0);
  return true;
}

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names{"office", "corridor", "stairs",   "curved", "creases", "wall",
                                              "box",    "hole",     "cylinder", "sphere", "empty"};
  return names;
}

Scene makeScene(const std::string& name, std::uint64_t seed) {
  if (name == "office") return makeOffice(seed);
  if (name == "corridor") return makeCorridor(seed);
  if (name == "stairs") return makeStairs(seed);
  if (name == "curved") return makeCurved(seed);
  if (name == "creases") return makeCreases(seed);
  Scene scene;
  if (makeAnalytic(name, scene)) return scene;
  std::string known;
  for (const std::string& n : sceneNames()) known += (known.empty() ? "" : ", ") + n;
  throw std::invalid_argument("scene is '" + name + "', allowed: " + known);
}

}  // namespace ppc::sim
