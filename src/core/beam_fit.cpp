// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr float kMinCosine = 0.02F;  // of incidence: the residual along a beam says nothing about a plane seen edge-on
constexpr float kNearShare = 0.5F;   // of the range
constexpr int kKeptPixels = 512;     // whose sums are kept in single precision
// Of normal errors up to 2.5 standard deviations: P(|x| < 2.5) over the same less 5 times their density there, the square
// of the limit in variances of what is left, and how the former changes with the latter.
constexpr double kScale = 1.0974, kLimit2 = 6.8587, kScaleSlope = -0.0565, kMaxScale = 1.3;
constexpr double kMinCondition = 1e-12;
constexpr double kLeastGrowth = -0.9;  // of n / d in a step: more would turn the plane over

// Sums of some hundred points, in lanes.
struct LaneSums {
  Lanes w = {}, wa = {}, wb = {}, waa = {}, wab = {}, wbb = {}, wh = {}, wha = {}, whb = {}, whh = {};
  Lanes h = {}, hh = {}, a = {}, b = {};
  LaneMask valid = {}, used = {}, kept = {};
  int whole = 0;  // points in lanes that are all used: counted once, not in `valid` and `used`

  void addTo(BeamSums& s) const {
    s.w += sumLanes(w);
    s.wa += sumLanes(wa);
    s.wb += sumLanes(wb);
    s.waa += sumLanes(waa);
    s.wab += sumLanes(wab);
    s.wbb += sumLanes(wbb);
    s.wh += sumLanes(wh);
    s.wha += sumLanes(wha);
    s.whb += sumLanes(whb);
    s.whh += sumLanes(whh);
    s.h += sumLanes(h);
    s.hh += sumLanes(hh);
    s.a += sumLanes(a);
    s.b += sumLanes(b);
    s.valid += countLanes(valid) + whole;
    s.used += countLanes(used) + whole;
    s.kept += countLanes(kept);
  }
};

// The same vector for all lanes, its coordinates in the order of a frame.
struct FrameVector {
  Lanes a, b, c;
  FrameVector(const Eigen::Vector3d& v, const BeamFrame& frame)
      : a(fill(static_cast<float>(v[frame.a()]))),
        b(fill(static_cast<float>(v[frame.b()]))),
        c(fill(static_cast<float>(v[frame.across()]))) {}
};

// Directions or origins of the beams, in the order of a frame.
struct FrameArrays {
  const float *a, *b, *c;
  FrameArrays(const std::vector<float>& x, const std::vector<float>& y, const std::vector<float>& z,
              const BeamFrame& frame) {
    const std::array<const float*, 3> all{x.data(), y.data(), z.data()};
    a = all[static_cast<std::size_t>(frame.a())];
    b = all[static_cast<std::size_t>(frame.b())];
    c = all[static_cast<std::size_t>(frame.across())];
  }
};

// Sums of points with given weights; beams may have origins of their own.
template <BeamWeights kWeights, bool kOrigins>
class BeamSummer {
 public:
  BeamSummer(const BeamGrid& grid, const BeamFrame& frame, const ErrorScale& scale)
      : grid_(grid),
        dir_(grid.dir_x, grid.dir_y, grid.dir_z, frame),
        origin_(grid.origin_x, grid.origin_y, grid.origin_z, frame),
        normal_(frame.plane().normal, frame),
        centre_(frame.centre(), frame),
        limit2_(fill(static_cast<float>(scale.limit * scale.limit))),
        cosine_share_(fill(static_cast<float>(1.0 / (1.0 + scale.softness)))),
        constant_share_(fill(static_cast<float>(scale.softness / (1.0 + scale.softness)))) {}

  void add(const PixelStretch& block, LaneSums& s) const {
    int i = block.begin;
    for (; i + kLanes <= block.end; i += kLanes) {
      addBeams([i](const float* from) { return loadLanes<Lanes>(from + i); }, fillMask(-1), s);
    }
    if (i == block.end) return;
    const int count = block.end - i;
    if (i + kLanes <= grid_.size()) {
      addBeams([i](const float* from) { return loadLanes<Lanes>(from + i); }, firstLanes(count), s);
    } else {  // nothing beyond the last pixel may be touched
      addBeams([i, count](const float* from) { return loadLanes<Lanes>(from + i, count); }, firstLanes(count), s);
    }
  }

 private:
  template <typename Load>
  void addBeams(const Load& load, LaneMask inside, LaneSums& s) const {
    const Lanes zero = {};
    Beams beams;
    beams.range = load(grid_.range.data());
    beams.ua = load(dir_.a);
    beams.ub = load(dir_.b);
    // From the centre, not from the frame's origin: short distances keep their digits.
    beams.oa = -centre_.a;
    beams.ob = -centre_.b;
    Lanes oc = -centre_.c;
    if constexpr (kOrigins) {
      beams.oa += load(origin_.a);
      beams.ob += load(origin_.b);
      oc += load(origin_.c);
    }
    beams.cosine = normal_.a * beams.ua + normal_.b * beams.ub + normal_.c * load(dir_.c);
    beams.height = normal_.a * beams.oa + normal_.b * beams.ob + normal_.c * oc;
    const LaneMask valid = (beams.range > zero) & inside;
    const LaneMask used = valid & (beams.cosine < fill(-kMinCosine));
    if (!anyLane(~used)) {  // most
      addUsed<true>(beams, valid, used, s);
      s.whole += kLanes;
    } else {
      addUsed<false>(beams, valid, used, s);
      s.valid += valid;
      s.used += used;
    }
  }

  struct Beams {
    Lanes range, ua, ub, oa, ob, cosine, height;
  };

  // kAll: all lanes are valid and used.
  template <bool kAll>
  void addUsed(const Beams& beams, LaneMask valid, LaneMask used, LaneSums& s) const {
    const auto only = [](LaneMask mask, Lanes lanes) { return kAll ? lanes : mask ? lanes : Lanes{}; };
    const Lanes h = only(valid, beams.height + beams.range * beams.cosine);
    const Lanes pa = only(valid, beams.oa + beams.range * beams.ua), pb = only(valid, beams.ob + beams.range * beams.ub);
    const Lanes cosine2 = beams.cosine * beams.cosine;
    Lanes w, moved = h, back;  // back: how far along the beam the point's place on the plane is, in h
    LaneMask kept = used;
    Lanes qa = pa, qb = pb;
    if constexpr (kWeights == BeamWeights::kInverse) {
      back = only(used, 1.0F / beams.cosine);
      w = only(used, cosine2);
      moved = only(used, h * (beams.range - h * back) / beams.range);
    } else {
      const Lanes weight = only(used, 1.0F / (cosine_share_ * cosine2 + constant_share_));
      back = cosine_share_ * beams.cosine * weight;
      if constexpr (kWeights == BeamWeights::kNear) {
        kept &= h * h <= kNearShare * kNearShare * beams.range * beams.range * cosine2;
      } else {
        kept &= h * h * weight <= limit2_;
      }
      w = reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(weight) & kept);  // less than choosing by the mask
      const Lanes across = h - h * back * beams.cosine;
      qa -= across * normal_.a;
      qb -= across * normal_.b;
    }
    qa -= h * back * beams.ua;
    qb -= h * back * beams.ub;
    const Lanes wa = w * qa, wb = w * qb, wh = w * moved;
    s.w += w;
    s.wa += wa;
    s.wb += wb;
    s.waa += wa * qa;
    s.wab += wa * qb;
    s.wbb += wb * qb;
    s.wh += wh;
    s.wha += wh * qa;
    s.whb += wh * qb;
    s.whh += wh * moved;
    s.h += h;
    s.hh += h * h;
    s.a += pa;
    s.b += pb;
    s.kept += kept;
  }

  const BeamGrid& grid_;
  FrameArrays dir_, origin_;
  FrameVector normal_, centre_;
  Lanes limit2_, cosine_share_, constant_share_;
};

template <BeamWeights kWeights, bool kOrigins>
BeamSums sumBlocks(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, const BeamFrame& frame,
                   const ErrorScale& scale) {
  const BeamSummer<kWeights, kOrigins> summer(grid, frame, scale);
  BeamSums sums;
  for (const PixelStretch* block = begin; block != end;) {
    LaneSums lanes;
    for (int pixels = 0; block != end && pixels < kKeptPixels; ++block) {
      pixels += block->end - block->begin;
      summer.add(*block, lanes);
    }
    lanes.addTo(sums);
  }
  return sums;
}

template <BeamWeights kWeights>
BeamSums sumBlocks(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, const BeamFrame& frame,
                   const ErrorScale& scale) {
  return grid.origin_x.empty() ? sumBlocks<kWeights, false>(grid, begin, end, frame, scale)
                               : sumBlocks<kWeights, true>(grid, begin, end, frame, scale);
}

}  // namespace

Eigen::Matrix3d equationsOf(const BeamSums& s) {
  Eigen::Matrix3d equations;
  equations << s.waa, s.wab, s.wa, s.wab, s.wbb, s.wb, s.wa, s.wb, s.w;
  return equations;
}

Eigen::Vector3d rightOf(const BeamSums& s) { return {s.wha, s.whb, s.wh}; }

int firstValid(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end) {
  for (const PixelStretch* stretch = begin; stretch != end; ++stretch) {
    for (int i = stretch->begin; i < stretch->end; ++i) {
      if (grid.valid(i)) return i;
    }
  }
  return -1;
}

BeamSums& BeamSums::combine(const BeamSums& o, int sign) {
  w += sign * o.w;
  wa += sign * o.wa;
  wb += sign * o.wb;
  waa += sign * o.waa;
  wab += sign * o.wab;
  wbb += sign * o.wbb;
  wh += sign * o.wh;
  wha += sign * o.wha;
  whb += sign * o.whb;
  whh += sign * o.whh;
  h += sign * o.h;
  hh += sign * o.hh;
  a += sign * o.a;
  b += sign * o.b;
  valid += sign * o.valid;
  used += sign * o.used;
  kept += sign * o.kept;
  return *this;
}

BeamFrame::BeamFrame(const Plane& plane, const Eigen::Vector3d& near) : plane_(plane) {
  // Numbers that are the same in single precision, as sums are about them.
  plane_.normal = plane.normal.cast<float>().cast<double>();
  centre_ = (near - plane.signedDistance(near) * plane.normal).cast<float>().cast<double>();
  plane_.d = plane_.normal.dot(centre_);
  Eigen::Index longest = 0;
  plane.normal.cwiseAbs().maxCoeff(&longest);
  const int across = static_cast<int>(longest);
  axes_ = {(across + 1) % 3, (across + 2) % 3, across};
}

Eigen::Vector3d BeamFrame::meanOf(const BeamSums& sums) const {
  Eigen::Vector3d mean;
  mean[a()] = sums.a / sums.valid;
  mean[b()] = sums.b / sums.valid;
  const Eigen::Vector3d& n = plane_.normal;
  mean[across()] = (sums.h / sums.valid - n[a()] * mean[a()] - n[b()] * mean[b()]) / n[across()];
  return centre_ + mean;
}

BeamSums sumBeams(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, const BeamFrame& frame,
                  BeamWeights weights, const ErrorScale& scale) {
  switch (weights) {
    case BeamWeights::kInverse:
      return sumBlocks<BeamWeights::kInverse>(grid, begin, end, frame, scale);
    case BeamWeights::kNear:
      return sumBlocks<BeamWeights::kNear>(grid, begin, end, frame, scale);
    case BeamWeights::kTrimmed:
      break;
  }
  return sumBlocks<BeamWeights::kTrimmed>(grid, begin, end, frame, scale);
}

double newtonScale(const BeamSums& sums, double limit) {
  if (!(limit < kNoLimit) || !(sums.whh > 0.0)) return 1.0;
  const double limit2 = limit * limit * sums.kept / sums.whh;
  return std::clamp(kScale + kScaleSlope * (limit2 - kLimit2), 1.0, kMaxScale);
}

double gainOf(const BeamSums& sums, const Eigen::Vector3d& step) {
  return step.dot(2.0 * rightOf(sums) - equationsOf(sums) * step);
}

std::optional<BeamStep> stepOf(const BeamSums& s, double scale) {
  if (s.kept < 3) return std::nullopt;
  const Eigen::Matrix3d equations = equationsOf(s);
  const Eigen::Vector3d right = rightOf(s);
  const Eigen::LDLT<Eigen::Matrix3d> solver(equations);
  if (solver.info() != Eigen::Success || !solver.isPositive() || !(solver.rcond() >= kMinCondition)) return std::nullopt;
  BeamStep step;
  step.x = scale * solver.solve(right);
  step.gain = gainOf(s, step.x);
  step.covariance = solver.solve(Eigen::Matrix3d::Identity());
  if (!step.x.allFinite() || !step.covariance.allFinite()) return std::nullopt;
  return step;
}

Plane movedBy(const BeamStep& step, const BeamFrame& frame, const Eigen::Vector3d& origin) {
  const Eigen::Vector3d centre = frame.centre() - origin;
  const double d = frame.plane().normal.dot(centre);
  const double growth = (step.x[0] * centre[frame.a()] + step.x[1] * centre[frame.b()] - step.x[2]) / d;
  const bool inversely = growth > kLeastGrowth;
  Eigen::Vector3d normal = (inversely ? 1.0 + growth : 1.0) * frame.plane().normal;
  normal[frame.a()] -= step.x[0];
  normal[frame.b()] -= step.x[1];
  const double length = normal.norm();
  const double offset = inversely ? d : normal.dot(centre) + step.x[2];
  normal /= length;
  return {normal, offset / length + normal.dot(origin)};
}

Eigen::Matrix<double, 4, 3> planeJacobian(const BeamFrame& frame, const Plane& moved) {
  // n' = n - x0 a - x1 b with d' = n' . c + x2, and then scaled to |n| = 1.
  Eigen::Matrix<double, 4, 3> jacobian = Eigen::Matrix<double, 4, 3>::Zero();
  jacobian(frame.a(), 0) = jacobian(frame.b(), 1) = -1.0;
  jacobian(3, 0) = -frame.centre()[frame.a()];
  jacobian(3, 1) = -frame.centre()[frame.b()];
  jacobian(3, 2) = 1.0;
  Eigen::Matrix4d scaling = Eigen::Matrix4d::Identity();
  scaling.topLeftCorner<3, 3>() -= moved.normal * moved.normal.transpose();
  scaling.block<1, 3>(3, 0) = -moved.d * moved.normal.transpose();
  return scaling * jacobian;
}

Eigen::Matrix4d planeCovariance(const BeamStep& step, const BeamFrame& frame, const Plane& moved, double variance) {
  const Eigen::Matrix<double, 4, 3> to_plane = planeJacobian(frame, moved);
  return variance * to_plane * step.covariance * to_plane.transpose();
}

}  // namespace ppc
