// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/random.h"
#include "patch_plane_clustering/sim/scanner.h"
#include "patch_plane_clustering/sim/scene.h"

#include <gtest/gtest.h>
#include <cmath>
#include <map>

namespace ppc::sim {
namespace {

using Eigen::Vector3d;

const std::vector<std::string> kRooms{"office", "corridor", "stairs", "curved", "creases"};

Vector3d anyDirection(Random& random) { return Vector3d{random.normal(), random.normal(), random.normal()}.normalized(); }

TEST(Scene, HierarchyFindsWhatExhaustiveSearchFinds) {
  for (const std::string& name : kRooms) {
    const Scene scene = makeScene(name, 7);
    Random random(1);
    for (int i = 0; i < 3000; ++i) {
      const Vector3d o = scene.tilt_base.translation();
      const Vector3d d = i < 3 ? Vector3d(Vector3d::Unit(i)) : anyDirection(random);
      double nearest = std::numeric_limits<double>::infinity();
      std::int32_t id = 0;
      Vector3d normal;
      for (const Surface& s : scene.surfaces()) {
        const double t = intersect(s, o, d, normal);
        if (t < nearest) {
          nearest = t;
          id = s.plane_id;
        }
      }
      const Hit hit = scene.cast(o, d);
      ASSERT_EQ(hit.range, nearest) << name;
      if (std::isfinite(nearest)) {
        ASSERT_EQ(hit.plane_id, id) << name;
      }
    }
  }
}

TEST(Scene, HitsLieOnTheirTruePlane) {
  for (const std::string& name : kRooms) {
    const Scene scene = makeScene(name, 3);
    const Eigen::Isometry3d to_base = scene.tilt_base.inverse();
    Random random(2);
    int planar = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d o = scene.tilt_base.translation(), d = anyDirection(random);
      const Hit hit = scene.cast(o, d);
      if (hit.plane_id == 0) continue;
      ++planar;
      const Plane plane = scene.planeInBase(hit.plane_id);
      ASSERT_LE(plane.d, 0.0);
      ASSERT_NEAR(plane.signedDistance(to_base * (o + hit.range * d)), 0.0, 1e-9) << name << " plane " << hit.plane_id;
      ASSERT_NEAR(hit.cos_incidence, std::abs(plane.normal.dot(to_base.linear() * d)), 1e-9);
    }
    EXPECT_GT(planar, 1500) << name;
  }
}

TEST(Scene, SameSeedSameSceneOtherSeedAnother) {
  for (const std::string& name : kRooms) {
    const Scene a = makeScene(name, 5), b = makeScene(name, 5), c = makeScene(name, 6);
    ASSERT_EQ(a.surfaces().size(), b.surfaces().size()) << name;
    Random random(4);
    int different = 0;
    for (int i = 0; i < 500; ++i) {
      const Vector3d d = anyDirection(random);
      const double range = a.cast(a.tilt_base.translation(), d).range;
      ASSERT_EQ(range, b.cast(b.tilt_base.translation(), d).range) << name;
      different += range != c.cast(c.tilt_base.translation(), d).range ? 1 : 0;
    }
    EXPECT_GT(different, 400) << name;
  }
}

TEST(Scene, RoomsShowAsManyPlanesAsTheyAreMadeFor) {
  for (const std::string& name : kRooms) {
    for (const std::uint64_t seed : {1, 2}) {
      const Sweep sweep = simulateSweep(name, "utm_30lx", ErrorModel::none(), seed, 100);
      std::map<std::int32_t, int> sizes;
      int missing = 0;
      for (std::size_t i = 0; i < sweep.labels.labels.size(); ++i) {
        ++sizes[sweep.labels.labels[i]];
        missing += std::isinf(sweep.image.ranges[i]) ? 1 : 0;
      }
      int regions = 0;
      for (const auto& [id, size] : sizes) regions += id > 0 && size >= 133 ? 1 : 0;  // 400 pixels of 300 lines
      const double pixels = static_cast<double>(sweep.labels.labels.size());
      EXPECT_GE(regions, name == "curved" ? 7 : 12) << name << seed;
      EXPECT_LE(regions, 35) << name << seed;
      EXPECT_LT(missing / pixels, name == "office" ? 0.25 : 0.001) << name << seed;  // windows
      if (name == "curved") {
        EXPECT_GT(sizes[0] / pixels, 0.03);
      }
    }
  }
}

TEST(Scene, StairsHaveEqualSteps) {
  const Scene scene = makeScene("stairs", 2);
  // Upward planes ahead, by height: treads.
  std::vector<double> heights;
  for (const Surface& s : scene.surfaces()) {
    if (s.kind == Surface::Kind::kFace && s.normal().z() > 0.999 && s.pose.translation().z() > 0.01 &&
        s.pose.translation().y() == 0.0 && s.bounds.max().x() < 3.0) {
      heights.push_back(s.pose.translation().z());
    }
  }
  ASSERT_GE(heights.size(), 7U);
  for (std::size_t i = 1; i < heights.size(); ++i) EXPECT_NEAR(heights[i] - heights[i - 1], heights[0], 1e-9);
  EXPECT_GT(heights[0], 0.14);
  EXPECT_LT(heights[0], 0.19);
}

TEST(Scene, BowTouchesLargeFacesOnlyAndCanBeTakenBack) {
  Scene scene = makeScene("office", 1);
  scene.bowWalls(0.005);
  int bowed = 0;
  for (const Surface& s : scene.surfaces()) {
    if (s.bow == 0.0) continue;
    ++bowed;
    EXPECT_DOUBLE_EQ(std::abs(s.bow), 0.005);
    EXPECT_GE(s.bounds.sizes().minCoeff(), 1.0);
  }
  EXPECT_GE(bowed, 6);
  scene.bowWalls(0.0);
  for (const Surface& s : scene.surfaces()) EXPECT_EQ(s.bow, 0.0);
}

TEST(Scene, FacesOfOnePlaneAreKnownAsSuch) {
  // Cheeks of a ramp and sides of the platform that it leads to.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = makeScene("creases", seed);
    const std::vector<std::int32_t> first = scene.coplanarIds();
    ASSERT_EQ(first.size(), static_cast<std::size_t>(scene.planeCount()) + 1);
    EXPECT_EQ(first[0], 0);
    for (std::int32_t id = 1; id <= scene.planeCount(); ++id) {
      const Plane plane = scene.planeInBase(id);
      EXPECT_LE(first[id], id);
      for (std::int32_t other = 1; other < id; ++other) {
        const Plane before = scene.planeInBase(other);
        const double apart = (plane.normal - before.normal).norm() + std::abs(plane.d - before.d);
        EXPECT_EQ(first[id] == first[other], apart < 1e-6) << seed << ": " << id << " and " << other << ", " << apart;
      }
    }
  }
  const std::vector<std::int32_t> of_box = makeScene("box", 1).coplanarIds();
  for (std::size_t id = 0; id < of_box.size(); ++id) EXPECT_EQ(of_box[id], static_cast<std::int32_t>(id));
}

TEST(Scene, EmptySceneIsNeverHit) {
  const Hit hit = makeScene("empty", 0).cast(Vector3d::Zero(), Vector3d::UnitX());
  EXPECT_TRUE(std::isinf(hit.range));
  EXPECT_EQ(hit.plane_id, 0);
}

TEST(Scene, UnknownNamesAreRefusedByName) {
  try {
    makeScene("attic", 0);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("'attic'"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("corridor"), std::string::npos);
  }
  for (const std::string& name : sceneNames()) EXPECT_NO_THROW(makeScene(name, 1)) << name;
  EXPECT_THROW(makeScene("box", 0).planeInBase(7), std::invalid_argument);
}

}  // namespace
}  // namespace ppc::sim
