// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/quadratic_fit.h"

#include "patch_plane_clustering/core/lanes.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kBlock = 64;  // samples summed in single precision

// The sums that differ: s^a t^b for a + b <= 4, and those with z.
struct Sums {
  Lanes one = {}, s = {}, t = {}, ss = {}, st = {}, tt = {}, sss = {}, sst = {}, stt = {}, ttt = {};
  Lanes ssss = {}, ssst = {}, sstt = {}, sttt = {}, tttt = {};
  Lanes z = {}, sz = {}, tz = {}, ssz = {}, stz = {}, ttz = {}, zz = {};

  void add(Lanes w, Lanes s1, Lanes t1, Lanes z1) {
    const Lanes ws = w * s1, wt = w * t1, wz = w * z1;
    const Lanes s2 = s1 * s1, t2 = t1 * t1, st1 = s1 * t1;
    const Lanes wss = ws * s1, wst = ws * t1, wtt = wt * t1;
    one += w;
    s += ws;
    t += wt;
    ss += wss;
    st += wst;
    tt += wtt;
    sss += wss * s1;
    sst += wss * t1;
    stt += wtt * s1;
    ttt += wtt * t1;
    ssss += wss * s2;
    ssst += wss * st1;
    sstt += wss * t2;
    sttt += wtt * st1;
    tttt += wtt * t2;
    z += wz;
    sz += wz * s1;
    tz += wz * t1;
    ssz += wz * s2;
    stz += wz * st1;
    ttz += wz * t2;
    zz += wz * z1;
  }

  void addTo(QuadraticSums& out) const {
    const Lanes products[6][6] = {{one, s, t, ss, st, tt},          {s, ss, st, sss, sst, stt},
                                  {t, st, tt, sst, stt, ttt},       {ss, sss, sst, ssss, ssst, sstt},
                                  {st, sst, stt, ssst, sstt, sttt}, {tt, stt, ttt, sstt, sttt, tttt}};
    const Lanes with_z[6] = {z, sz, tz, ssz, stz, ttz};
    for (int row = 0; row < 6; ++row) {
      for (int col = 0; col <= row; ++col) out.normal(row, col) += sumLanes(products[row][col]);
      out.right[row] += sumLanes(with_z[row]);
    }
    out.total += sumLanes(zz);
  }
};

// The terms about an origin at (-s, -t): m(s' + s, t' + t) = shift m(s', t').
Matrix6 shiftOfTerms(double s, double t) {
  Matrix6 shift = Matrix6::Identity();
  shift(1, 0) = s;
  shift(2, 0) = t;
  shift.row(3) << s * s, 2.0 * s, 0.0, 1.0, 0.0, 0.0;
  shift.row(4) << s * t, t, s, 0.0, 1.0, 0.0;
  shift.row(5) << t * t, 0.0, 2.0 * t, 0.0, 0.0, 1.0;
  return shift;
}

}  // namespace

QuadraticSums& QuadraticSums::operator+=(const QuadraticSums& o) {
  normal += o.normal;
  right += o.right;
  total += o.total;
  used += o.used;
  return *this;
}

QuadraticSums sumQuadratic(const SurfaceSamples& samples, const Eigen::Vector3d& s_axis, const Eigen::Vector3d& t_axis,
                           int of_groups) {
  QuadraticSums out;
  const Eigen::Vector3f s = s_axis.cast<float>(), t = t_axis.cast<float>();
  const auto per_height = static_cast<float>(1.0 / s_axis.cross(t_axis).dot(samples.normal));
  const auto step = static_cast<std::size_t>(of_groups);
  for (std::size_t begin = 0; begin < samples.size; begin += kBlock * step) {
    Sums sums;
    for (std::size_t i = begin; i < std::min(begin + kBlock * step, samples.size); i += kLanes * step) {
      const auto x = loadLanes<Lanes>(samples.x + i), y = loadLanes<Lanes>(samples.y + i);
      const auto z = loadLanes<Lanes>(samples.z + i);
      sums.add(loadLanes<Lanes>(samples.weight + i), s.x() * x + s.y() * y + s.z() * z, t.x() * x + t.y() * y + t.z() * z,
               per_height * loadLanes<Lanes>(samples.height + i));
    }
    sums.addTo(out);
  }
  out.normal.triangularView<Eigen::StrictlyUpper>() = out.normal.transpose();
  out.used = samples.used;
  return out;
}

QuadraticSums sumQuadraticAbout(const Eigen::Vector3d& origin, const SurfaceSamples& samples, const Eigen::Vector3d& s_axis,
                                const Eigen::Vector3d& t_axis, int of_groups) {
  const Eigen::Vector3d n = s_axis.cross(t_axis), moved = samples.center - origin;
  QuadraticSums sums = sumQuadratic(samples, s_axis, t_axis, of_groups);
  // The samples' own plane, over which their z is, in terms about their center: z = base . m.
  const double cosine = n.dot(samples.normal);
  Vector6 base = Vector6::Zero();
  base << n.dot(moved), -s_axis.dot(samples.normal) / cosine, -t_axis.dot(samples.normal) / cosine, 0.0, 0.0, 0.0;
  const Vector6 of_base = sums.normal * base;
  sums.total += base.dot(2.0 * sums.right + of_base);
  sums.right += of_base;
  const Matrix6 shift = shiftOfTerms(s_axis.dot(moved), t_axis.dot(moved));
  sums.right = (shift * sums.right).eval();
  sums.normal = (shift * sums.normal * shift.transpose()).eval();
  return sums;
}

QuadraticFit fitQuadratic(const QuadraticSums& sums) {
  QuadraticFit fit;
  if (sums.used < 6) return fit;
  // Coordinates of order one keep the normal equations well conditioned.
  const double scale = 2.0 * std::sqrt((sums.normal(1, 1) + sums.normal(2, 2)) / sums.normal(0, 0));
  if (!(scale > 0.0)) return fit;
  Vector6 units;
  units << 1.0, 1.0 / scale, 1.0 / scale, 1.0 / (scale * scale), 1.0 / (scale * scale), 1.0 / (scale * scale);
  Matrix6 normal = units.asDiagonal() * sums.normal * units.asDiagonal();
  const Vector6 right = units.cwiseProduct(sums.right);
  fit.weight = normal(0, 0);
  fit.scatter = sums.normal.block<2, 2>(1, 1) / fit.weight;
  normal.diagonal().array() += 1e-9 * normal.trace();  // for terms that the samples do not determine
  const Vector6 quadratic = normal.ldlt().solve(right);
  const Eigen::Vector3d linear = Eigen::Matrix3d(normal.topLeftCorner<3, 3>()).ldlt().solve(right.head<3>());
  fit.plane = linear.cwiseProduct(units.head<3>());
  fit.plane_chi2 = std::max(0.0, sums.total - linear.dot(right.head<3>()));
  fit.quadratic_chi2 = std::max(0.0, sums.total - quadratic.dot(right));
  fit.hessian << 2.0 * quadratic[3], quadratic[4], quadratic[4], 2.0 * quadratic[5];
  fit.hessian /= scale * scale;
  return fit;
}

}  // namespace ppc
