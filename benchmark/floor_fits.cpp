// SPDX-License-Identifier: BSD-3-Clause
#include "floor.h"
#include "lanes.h"

#include <algorithm>

namespace ppc::bench {
namespace {

struct Vector {
  Lanes x, y, z;
};

Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Lanes dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// The longer of two vectors.
void takeLonger(const Vector& candidate, Vector& best, Lanes& length2) {
  const Lanes own = dot(candidate, candidate);
  const LaneMask longer = own > length2;
  best = {select(longer, candidate.x, best.x), select(longer, candidate.y, best.y), select(longer, candidate.z, best.z)};
  length2 = select(longer, own, length2);
}

// Smallest eigenvalue of a symmetric matrix of trace 1 that is positive semi-definite. Its characteristic polynomial rises
// and is concave from 0 to the root: Newton's method comes from below and never overshoots.
Lanes smallestEigenvalue(const Lanes& minors, const Lanes& determinant) {
  Lanes root{};
  for (int i = 0; i < 6; ++i) {
    const Lanes value = ((root - 1.0F) * root + minors) * root - determinant;
    const Lanes slope = (3.0F * root - 2.0F) * root + minors;
    root -= select(slope > 1e-12F, value / slope, Lanes{});
  }
  return select(root > 0.0F, root, Lanes{});
}

struct Result {
  Vector normal;
  Lanes d, variance;
};

void fitFour(const FloorSums& s, std::size_t i, Result& out) {
  const Lanes n = load(&s.n[i]);
  const LaneMask enough = n >= 3.0F;
  const Lanes inverse = 1.0F / select(enough, n, Lanes{1.0F, 1.0F, 1.0F, 1.0F});
  const Vector mean{load(&s.x[i]) * inverse, load(&s.y[i]) * inverse, load(&s.z[i]) * inverse};
  Lanes xx = load(&s.xx[i]) * inverse - mean.x * mean.x, xy = load(&s.xy[i]) * inverse - mean.x * mean.y;
  Lanes xz = load(&s.xz[i]) * inverse - mean.x * mean.z, yy = load(&s.yy[i]) * inverse - mean.y * mean.y;
  Lanes yz = load(&s.yz[i]) * inverse - mean.y * mean.z, zz = load(&s.zz[i]) * inverse - mean.z * mean.z;
  const Lanes trace = xx + yy + zz;
  const Lanes scale = 1.0F / select(trace > 1e-30F, trace, Lanes{1.0F, 1.0F, 1.0F, 1.0F});
  xx *= scale, xy *= scale, xz *= scale, yy *= scale, yz *= scale, zz *= scale;

  const Lanes minor_x = yy * zz - yz * yz, minor_y = xx * zz - xz * xz, minor_z = xx * yy - xy * xy;
  const Lanes determinant = xx * minor_x - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy);
  const Lanes smallest = smallestEigenvalue(minor_x + minor_y + minor_z, determinant);

  // The rows of (matrix - eigenvalue) are perpendicular to the eigenvector: so are their cross products along it.
  const Vector row_x{xx - smallest, xy, xz}, row_y{xy, yy - smallest, yz}, row_z{xz, yz, zz - smallest};
  Vector normal = cross(row_x, row_y);
  Lanes length2 = dot(normal, normal);
  takeLonger(cross(row_x, row_z), normal, length2);
  takeLonger(cross(row_y, row_z), normal, length2);
  const LaneMask known = enough & (length2 > 0.0F);
  Lanes factor = 1.0F / squareRoot(select(known, length2, Lanes{1.0F, 1.0F, 1.0F, 1.0F}));
  const Vector point{mean.x + load(&s.origin_x[i]), mean.y + load(&s.origin_y[i]), mean.z + load(&s.origin_z[i])};
  factor = keep(known, select(dot(normal, point) > 0.0F, -factor, factor));
  out.normal = {normal.x * factor, normal.y * factor, normal.z * factor};
  out.d = dot(out.normal, point);
  out.variance = keep(known, smallest * trace);
}

}  // namespace

void fitPatches(const FloorSums& sums, FloorPlanes& planes) {
  const std::size_t patches = sums.n.size();
  for (auto* v : {&planes.normal_x, &planes.normal_y, &planes.normal_z, &planes.d, &planes.variance}) v->resize(patches);
  for (std::size_t i = 0; i < patches && patches >= kLanes; i += kLanes) {
    const std::size_t first = std::min(i, patches - kLanes);  // the last four overlap those before
    Result result;
    fitFour(sums, first, result);
    store(&planes.normal_x[first], result.normal.x);
    store(&planes.normal_y[first], result.normal.y);
    store(&planes.normal_z[first], result.normal.z);
    store(&planes.d[first], result.d);
    store(&planes.variance[first], result.variance);
  }
}

}  // namespace ppc::bench
