// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ppc::sim {
namespace {

constexpr double kMiss = std::numeric_limits<double>::infinity();
constexpr double kNear = 1e-6;

Eigen::Isometry3d frame(const Eigen::Vector3d& origin, const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = x.normalized();
  pose.linear().col(1) = y.normalized();
  pose.linear().col(2) = x.cross(y).normalized();
  pose.translation() = origin;
  return pose;
}

Eigen::Isometry3d frameAlong(const Eigen::Vector3d& origin, const Eigen::Vector3d& z) {
  const Eigen::Vector3d x = z.unitOrthogonal();
  return frame(origin, x, z.cross(x));
}

bool inside(const Ring& ring, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    if ((ring[i].y() > p.y()) != (ring[j].y() > p.y()) &&
        p.x() < (ring[j].x() - ring[i].x()) * (p.y() - ring[i].y()) / (ring[j].y() - ring[i].y()) + ring[i].x()) {
      in = !in;
    }
  }
  return in;
}

bool onFace(const Surface& s, const Eigen::Vector2d& p) {
  if (!s.bounds.contains(p) || (!s.outline.empty() && !inside(s.outline, p))) return false;
  return std::none_of(s.holes.begin(), s.holes.end(), [&](const Ring& hole) { return inside(hole, p); });
}

// Height of the bow over the plane and its slopes.
struct Bow {
  double height, du, dv;
};

Bow bowAt(const Surface& s, double u, double v) {
  const Eigen::Vector2d size = s.bounds.sizes();
  const double a = M_PI * std::clamp((u - s.bounds.min().x()) / size.x(), 0.0, 1.0);
  const double b = M_PI * std::clamp((v - s.bounds.min().y()) / size.y(), 0.0, 1.0);
  return {s.bow * std::sin(a) * std::sin(b), s.bow * M_PI / size.x() * std::cos(a) * std::sin(b),
          s.bow * M_PI / size.y() * std::sin(a) * std::cos(b)};
}

double intersectFace(const Surface& s, const Eigen::Vector3d& o, const Eigen::Vector3d& d, Eigen::Vector3d& normal) {
  if (d.z() == 0.0) return kMiss;
  double t = -o.z() / d.z();
  normal = Eigen::Vector3d::UnitZ();
  if (s.bow != 0.0) {
    // Newton on z(t) - bow(u(t), v(t)): the bow is shallow, a few steps reach it.
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d p = o + t * d;
      const Bow bow = bowAt(s, p.x(), p.y());
      const double slope = d.z() - bow.du * d.x() - bow.dv * d.y();
      if (std::abs(slope) < 1e-9) return kMiss;
      const double step = (p.z() - bow.height) / slope;
      t -= step;
      normal = Eigen::Vector3d(-bow.du, -bow.dv, 1.0);
      if (std::abs(step) < 1e-9) break;
    }
    normal.normalize();
  }
  if (!(t > kNear)) return kMiss;
  const Eigen::Vector3d p = o + t * d;
  return onFace(s, p.head<2>()) ? t : kMiss;
}

double intersectDisc(const Surface& s, const Eigen::Vector3d& o, const Eigen::Vector3d& d, Eigen::Vector3d& normal) {
  if (d.z() == 0.0) return kMiss;
  const double t = -o.z() / d.z();
  normal = Eigen::Vector3d::UnitZ();
  return t > kNear && (o + t * d).head<2>().squaredNorm() <= s.radius * s.radius ? t : kMiss;
}

double intersectCylinder(const Surface& s, const Eigen::Vector3d& o, const Eigen::Vector3d& d, Eigen::Vector3d& normal) {
  const double a = d.head<2>().squaredNorm();
  const double b = o.head<2>().dot(d.head<2>());
  const double c = o.head<2>().squaredNorm() - s.radius * s.radius;
  const double disc = b * b - a * c;
  if (a == 0.0 || disc < 0.0) return kMiss;
  for (const double t : {(-b - std::sqrt(disc)) / a, (-b + std::sqrt(disc)) / a}) {
    const double z = o.z() + t * d.z();
    if (t > kNear && z >= 0.0 && z <= s.length) {
      normal << (o + t * d).head<2>() / s.radius, 0.0;
      return t;
    }
  }
  return kMiss;
}

double intersectSphere(const Surface& s, const Eigen::Vector3d& o, const Eigen::Vector3d& d, Eigen::Vector3d& normal) {
  const double b = o.dot(d);
  const double disc = b * b - o.squaredNorm() + s.radius * s.radius;
  if (disc < 0.0) return kMiss;
  for (const double t : {-b - std::sqrt(disc), -b + std::sqrt(disc)}) {
    if (t > kNear) {
      normal = (o + t * d) / s.radius;
      return t;
    }
  }
  return kMiss;
}

}  // namespace

Surface makeRectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  Surface s;
  s.pose = frame(corner, u, v);
  s.bounds = Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d(u.norm(), v.norm()));
  return s;
}

Surface makePolygon(const Eigen::Vector3d& origin, const Eigen::Vector3d& u, const Eigen::Vector3d& v, Ring outline) {
  Surface s;
  s.pose = frame(origin, u, v);
  s.bounds.setEmpty();
  for (const auto& p : outline) s.bounds.extend(p);
  s.outline = std::move(outline);
  return s;
}

Surface makeDisc(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius) {
  Surface s;
  s.kind = Surface::Kind::kDisc;
  s.pose = frameAlong(centre, normal.normalized());
  s.radius = radius;
  return s;
}

Surface makeCylinder(const Eigen::Vector3d& base, const Eigen::Vector3d& axis, double radius) {
  Surface s;
  s.kind = Surface::Kind::kCylinder;
  s.pose = frameAlong(base, axis.normalized());
  s.radius = radius;
  s.length = axis.norm();
  return s;
}

Surface makeSphere(const Eigen::Vector3d& centre, double radius) {
  Surface s;
  s.kind = Surface::Kind::kSphere;
  s.pose.translation() = centre;
  s.radius = radius;
  return s;
}

Ring makeRectangularRing(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

double intersect(const Surface& s, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 Eigen::Vector3d& normal) {
  const Eigen::Matrix3d rotation = s.pose.linear().transpose();
  const Eigen::Vector3d o = rotation * (origin - s.pose.translation());
  const Eigen::Vector3d d = rotation * direction;
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  double t = kMiss;
  switch (s.kind) {
    case Surface::Kind::kFace:
      t = intersectFace(s, o, d, n);
      break;
    case Surface::Kind::kDisc:
      t = intersectDisc(s, o, d, n);
      break;
    case Surface::Kind::kCylinder:
      t = intersectCylinder(s, o, d, n);
      break;
    case Surface::Kind::kSphere:
      t = intersectSphere(s, o, d, n);
      break;
  }
  if (t < kMiss) normal = s.pose.linear() * n;
  return t;
}

Eigen::AlignedBox3d boundingBox(const Surface& s) {
  Eigen::Vector3d low, high;
  switch (s.kind) {
    case Surface::Kind::kFace:
      low << s.bounds.min(), -std::abs(s.bow);
      high << s.bounds.max(), std::abs(s.bow);
      break;
    case Surface::Kind::kDisc:
      low << -s.radius, -s.radius, 0.0;
      high = -low;
      break;
    case Surface::Kind::kCylinder:
      low << -s.radius, -s.radius, 0.0;
      high << s.radius, s.radius, s.length;
      break;
    case Surface::Kind::kSphere:
      high = Eigen::Vector3d::Constant(s.radius);
      low = -high;
      break;
  }
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    box.extend(s.pose * Eigen::Vector3d((corner & 1) != 0 ? high.x() : low.x(), (corner & 2) != 0 ? high.y() : low.y(),
                                        (corner & 4) != 0 ? high.z() : low.z()));
  }
  // A thin margin keeps axis-parallel faces from vanishing in the slab test.
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(1e-6);
  return {box.min() - margin, box.max() + margin};
}

}  // namespace ppc::sim
