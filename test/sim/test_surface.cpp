// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/random.h"
#include "patch_plane_clustering/sim/surface.h"

#include <gtest/gtest.h>
#include <cmath>

namespace ppc::sim {
namespace {

using Eigen::Vector3d;

double rangeTo(const Surface& s, const Vector3d& origin, const Vector3d& direction, Vector3d* normal = nullptr) {
  Vector3d n = Vector3d::Zero();
  const double t = intersect(s, origin, direction.normalized(), n);
  if (normal != nullptr) *normal = n;
  return t;
}

TEST(Surface, RectangleIsHitWithinItsEdgesFromBothSides) {
  const Surface s = makeRectangle({2, -1, -1}, {0, 2, 0}, {0, 0, 2});
  EXPECT_TRUE(s.normal().isApprox(Vector3d::UnitX()));
  EXPECT_DOUBLE_EQ(rangeTo(s, Vector3d::Zero(), Vector3d::UnitX()), 2.0);
  EXPECT_DOUBLE_EQ(rangeTo(s, {5, 0, 0}, -Vector3d::UnitX()), 3.0);
  EXPECT_NEAR(rangeTo(s, Vector3d::Zero(), {2, 0.999, 0.999}), std::sqrt(4 + 2 * 0.999 * 0.999), 1e-12);
  EXPECT_TRUE(std::isinf(rangeTo(s, Vector3d::Zero(), {2, 1.001, 0})));
  EXPECT_TRUE(std::isinf(rangeTo(s, Vector3d::Zero(), -Vector3d::UnitX())));
  EXPECT_TRUE(std::isinf(rangeTo(s, Vector3d::Zero(), Vector3d::UnitY())));
}

TEST(Surface, HoleLetsTheRayThrough) {
  Surface s = makeRectangle({2, -1, -1}, {0, 2, 0}, {0, 0, 2});
  s.holes.push_back(makeRectangularRing({0.9, 0.9}, {1.1, 1.1}));
  EXPECT_TRUE(std::isinf(rangeTo(s, Vector3d::Zero(), Vector3d::UnitX())));
  EXPECT_NEAR(rangeTo(s, Vector3d::Zero(), {2, 0.11, 0}), std::sqrt(4 + 0.11 * 0.11), 1e-12);
}

TEST(Surface, PolygonFollowsItsOutline) {
  // Triangle in the plane y = 1 with a right angle at (0, 1, 0).
  const Surface s = makePolygon({0, 1, 0}, Vector3d::UnitX(), Vector3d::UnitZ(), {{0, 0}, {1, 0}, {1, 1}});
  EXPECT_NEAR(rangeTo(s, {0.8, 0, 0.5}, Vector3d::UnitY()), 1.0, 1e-12);
  EXPECT_TRUE(std::isinf(rangeTo(s, {0.5, 0, 0.8}, Vector3d::UnitY())));
}

TEST(Surface, DiscEndsAtItsRadius) {
  const Surface s = makeDisc({0, 0, 3}, Vector3d::UnitZ(), 0.5);
  EXPECT_NEAR(rangeTo(s, {0.3, 0.3, 0}, Vector3d::UnitZ()), 3.0, 1e-12);
  EXPECT_TRUE(std::isinf(rangeTo(s, {0.4, 0.4, 0}, Vector3d::UnitZ())));
}

TEST(Surface, CylinderIsHitOutsideAndInside) {
  const Surface s = makeCylinder({3, 0, -1}, {0, 0, 2}, 0.5);
  Vector3d normal;
  EXPECT_NEAR(rangeTo(s, Vector3d::Zero(), Vector3d::UnitX(), &normal), 2.5, 1e-12);
  EXPECT_NEAR(std::abs(normal.dot(Vector3d::UnitX())), 1.0, 1e-12);
  EXPECT_NEAR(rangeTo(s, {3, 0, 0}, Vector3d::UnitX()), 0.5, 1e-12);
  EXPECT_TRUE(std::isinf(rangeTo(s, {0, 0, 1.1}, Vector3d::UnitX())));
  // Through the open top onto the inner wall.
  EXPECT_NEAR(rangeTo(s, {2.5, 0, 1.5}, {1, 0, -1}), std::sqrt(2.0), 1e-9);
}

TEST(Surface, SphereIsHitOutsideAndInside) {
  const Surface s = makeSphere({4, 0, 0}, 1.0);
  Vector3d normal;
  EXPECT_NEAR(rangeTo(s, {0, 0.6, 0}, Vector3d::UnitX(), &normal), 3.2, 1e-12);
  EXPECT_NEAR(normal.dot(Vector3d::UnitX()), -0.8, 1e-12);
  EXPECT_NEAR(rangeTo(s, {4, 0, 0}, Vector3d::UnitZ()), 1.0, 1e-12);
}

TEST(Surface, BowBulgesByItsAmplitudeAndKeepsTheBorder) {
  Surface s = makeRectangle({3, -2, -1}, {0, 4, 0}, {0, 0, 2});
  s.bow = 0.005;
  // The normal is +x, so the hump lies behind the plane as seen from the origin.
  EXPECT_NEAR(rangeTo(s, Vector3d::Zero(), Vector3d::UnitX()), 3.005, 1e-9);
  EXPECT_NEAR(rangeTo(s, {0, 1.0, 0}, Vector3d::UnitX()), 3.0 + 0.005 * std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(rangeTo(s, {0, 1.9999, 0}, Vector3d::UnitX()), 3.0, 1e-5);
  // Slanting rays hit the same surface: u = y + 2, v = z + 1 in the face's own frame.
  Vector3d normal;
  const Vector3d d = Vector3d(3, 1.5, 0.2).normalized();
  const Vector3d p = rangeTo(s, Vector3d::Zero(), d, &normal) * d;
  EXPECT_NEAR(p.x() - 3.0, 0.005 * std::sin(M_PI * (p.y() + 2) / 4) * std::sin(M_PI * (p.z() + 1) / 2), 1e-9);
  EXPECT_LT(std::abs(normal.x()), 1.0);
  EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
}

TEST(Surface, BoundingBoxHoldsEveryHit) {
  Surface bowed = makeRectangle({1, -1, 0.5}, {0, 2, 0}, {1, 0, 1});
  bowed.bow = 0.05;
  const std::vector<Surface> surfaces{bowed, makeDisc({1, 1, 1}, {1, 2, 3}, 0.7),
                                      makeCylinder({2, 0, 0}, {0.3, 1, 0.5}, 0.4), makeSphere({-2, 1, 0}, 0.8)};
  Random random(3);
  for (const Surface& s : surfaces) {
    const Eigen::AlignedBox3d box = boundingBox(s);
    int hits = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d o{random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4)};
      const Vector3d d = Vector3d{random.normal(), random.normal(), random.normal()}.normalized();
      const double t = rangeTo(s, o, d);
      if (!std::isfinite(t)) continue;
      ++hits;
      ASSERT_TRUE(box.contains(o + t * d)) << "kind " << static_cast<int>(s.kind);
    }
    EXPECT_GT(hits, 50);
  }
}

}  // namespace
}  // namespace ppc::sim
