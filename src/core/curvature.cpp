// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/parallel.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace ppc {
namespace {

constexpr int kMaxSamples = 1500;
constexpr double kSignificance = 25.0;  // far beyond chi-square with 3 degrees of freedom
constexpr double kMinAmplitude = 0.5;   // of a bend, in tolerances of distance
constexpr int kStripSizes = 2;          // largest size of such a strip over its neighbour's
constexpr double kWeakTurn = 0.31;      // of a strip beside a curved one, in max_turn
constexpr double kWeakAmplitude = 0.2;  // likewise, in tolerances of distance
constexpr double kFanAngle = 0.54;      // smallest angle between two strips of a fan, in max_turn
constexpr double kNarrowAngle = 0.22;   // likewise, if they bend as they are turned against each other
constexpr double kNarrowRadius = 4.0;   // largest radius of such strips: wider bows are those of ceilings and walls [m]
constexpr double kNarrowTurn = 0.6;     // turn of each over the angle between them that makes it so
constexpr int kFanSizes = 6;            // largest ratio of their sizes
constexpr double kFanRatio = 0.15;      // misfit of one quadratic surface over that of one plane, for two strips of a fan
constexpr double kFanMisfit = 0.1;      // the same misfit per point, in units of the noise variance
constexpr double kEdgeTolerance = 3.0;  // of a bent edge of a plane, in tolerances of distance
constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct Sample {
  Eigen::Vector3d point;
  double sigma;   // across the region's plane [m]
  double weight;  // pixels it stands for
};

// A sampled region: its plane by total least squares, and samples near that plane.
struct SampledRegion {
  std::int32_t id = 0;
  int points = 0;
  Plane plane;
  Bend bend;
  std::vector<Sample> samples;
};

SampledRegion sampleRegion(const BeamGrid& grid, std::int32_t id, int points, int stride, const std::vector<int>& pixels,
                           const NoiseModel& noise) {
  SampledRegion region;
  region.id = id;
  region.points = points;
  const auto n = static_cast<double>(pixels.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), beams = Eigen::Vector3d::Zero();
  for (const int i : pixels) {
    mean += grid.point(i).cast<double>() / n;
    beams += grid.direction(i).cast<double>();
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const int i : pixels) {
    const Eigen::Vector3d p = grid.point(i).cast<double>() - mean;
    scatter(0, 0) += p.x() * p.x();
    scatter(1, 0) += p.y() * p.x();
    scatter(2, 0) += p.z() * p.x();
    scatter(1, 1) += p.y() * p.y();
    scatter(2, 1) += p.z() * p.y();
    scatter(2, 2) += p.z() * p.z();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.dot(beams) > 0.0) normal = -normal;
  region.plane = {normal, normal.dot(mean)};
  const double rms = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / n);
  region.samples.reserve(pixels.size());
  for (const int i : pixels) {
    const Eigen::Vector3d p = grid.point(i).cast<double>();
    const double cosine = std::max(0.1, -normal.dot(grid.direction(i).cast<double>()));
    const double sigma = noise.sigma(grid.range[i]) * cosine;
    if (std::abs(region.plane.signedDistance(p)) > 4.0 * std::max(sigma, rms)) continue;
    region.samples.push_back({p, sigma, static_cast<double>(stride)});
  }
  return region;
}

// Least-squares plane and quadratic surface z(s, t) of samples over a given tangent frame.
struct QuadraticFit {
  double plane_chi2 = 0.0, quadratic_chi2 = 0.0;
  double weight = 0.0;  // sum of 1 / sigma^2 [1/m^2]
  double points = 0.0;
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();  // [1/m]
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();  // [m^2]
};

QuadraticFit fitQuadratic(const Eigen::Vector3d& n, const std::vector<const std::vector<Sample>*>& groups) {
  QuadraticFit fit;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (const auto* group : groups) {
    for (const Sample& sample : *group) center += sample.point;
    count += group->size();
  }
  if (count < 6) return fit;
  center /= static_cast<double>(count);
  double spread = 0.0;
  for (const auto* group : groups) {
    for (const Sample& sample : *group) spread = std::max(spread, (sample.point - center).squaredNorm());
  }
  const double scale = std::sqrt(spread);  // coordinates of order one keep the normal equations well conditioned
  if (!(scale > 0.0)) return fit;
  const Eigen::Vector3d s_axis = n.unitOrthogonal();
  const Eigen::Vector3d t_axis = n.cross(s_axis);
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double total = 0.0;
  for (const auto* group : groups) {
    for (const Sample& sample : *group) {
      const Eigen::Vector3d p = sample.point - center;
      const double s = s_axis.dot(p) / scale, t = t_axis.dot(p) / scale, z = n.dot(p);
      const double w = sample.weight / (sample.sigma * sample.sigma);
      const double terms[6] = {1.0, s, t, s * s, s * t, t * t};
      for (int row = 0; row < 6; ++row) {  // the lower triangle
        const double weighted = w * terms[row];
        right[row] += weighted * z;
        for (int col = 0; col <= row; ++col) normal(row, col) += weighted * terms[col];
      }
      total += w * z * z;
      fit.points += sample.weight;
    }
  }
  normal = Matrix6(normal.selfadjointView<Eigen::Lower>());
  fit.weight = normal(0, 0);
  fit.scatter = normal.block<2, 2>(1, 1);
  const double ridge = 1e-9 * normal.trace();
  const Vector6 quadratic = Matrix6(normal + ridge * Matrix6::Identity()).ldlt().solve(right);
  const Eigen::Vector3d linear =
      Eigen::Matrix3d(normal.topLeftCorner<3, 3>() + ridge * Eigen::Matrix3d::Identity()).ldlt().solve(right.head<3>());
  fit.plane_chi2 = std::max(0.0, total - linear.dot(right.head<3>()));
  fit.quadratic_chi2 = std::max(0.0, total - quadratic.dot(right));
  fit.hessian << 2.0 * quadratic[3], quadratic[4], quadratic[4], 2.0 * quadratic[5];
  fit.hessian /= scale * scale;
  fit.scatter *= scale * scale / fit.weight;
  return fit;
}

Bend bendOf(const QuadraticFit& fit) {
  Bend bend;
  if (!(fit.weight > 0.0)) return bend;
  bend.excess = std::max(0.0, fit.plane_chi2 - fit.quadratic_chi2);
  bend.amplitude = std::sqrt(bend.excess / fit.weight);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(fit.hessian);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d axis = eigen.eigenvectors().col(k);
    const double width = kUniformWidth * std::sqrt(std::max(0.0, axis.dot(fit.scatter * axis)));
    bend.turn = std::max(bend.turn, std::abs(eigen.eigenvalues()[k]) * width);
  }
  return bend;
}

// Radius of an evenly sampled strip of a cylinder [m]: its parabola of height h = w^2 / 8 R over the width w = turn R has
// the root mean square 2 h / (3 sqrt 5).
double radiusOf(const Bend& bend) { return 12.0 * std::sqrt(5.0) * bend.amplitude / (bend.turn * bend.turn); }

// Pairs of labels that are 4-neighbours in the image, or parted by up to `gap` pixels.
std::set<std::pair<std::int32_t, std::int32_t>> touchingLabels(const LabelImage& labels, int gap) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  std::pair<std::int32_t, std::int32_t> last;  // borders are long: most meetings repeat the one before
  const auto meet = [&](std::int32_t a, std::int32_t b) {
    const std::pair<std::int32_t, std::int32_t> pair(std::min(a, b), std::max(a, b));
    if (b == 0 || pair == last) return;
    last = pair;
    pairs.insert(pair);
  };
  for (int r = 0; r < labels.rows; ++r) {
    for (int c = 0; c < labels.cols; ++c) {
      const std::size_t i = static_cast<std::size_t>(r) * labels.cols + c;
      const std::int32_t* at = labels.labels.data() + i;
      if (r + 1 < labels.rows && c + kLanes < labels.cols) {  // four pixels inside of a region
        const auto here = loadLanes<LaneMask>(at);
        if (!anyLane((here != loadLanes<LaneMask>(at + 1)) | (here != loadLanes<LaneMask>(at + labels.cols)))) {
          c += kLanes - 1;
          continue;
        }
      }
      const std::int32_t label = *at;
      if (label == 0) continue;
      // Where the next pixel has the same label, it finds what lies beyond.
      if (c + 1 < labels.cols && labels.labels[i + 1] != label) {
        for (int g = 1; g <= gap + 1 && c + g < labels.cols; ++g) {
          if (labels.labels[i + g] != label) meet(label, labels.labels[i + g]);
        }
      }
      const auto down = static_cast<std::size_t>(labels.cols);
      if (r + 1 < labels.rows && labels.labels[i + down] != label) {
        for (int g = 1; g <= gap + 1 && r + g < labels.rows; ++g) {
          if (labels.labels[i + g * down] != label) meet(label, labels.labels[i + g * down]);
        }
      }
    }
  }
  return pairs;
}

// One smooth surface serves both as well as two of their own would, one plane does not.
bool isSmooth(const SampledRegion& a, const SampledRegion& b, const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d n = (a.points * a.plane.normal + b.points * b.plane.normal).normalized();
  const QuadraticFit fit_a = fitQuadratic(n, {&a.samples});
  const QuadraticFit fit_b = fitQuadratic(n, {&b.samples});
  const QuadraticFit both = fitQuadratic(n, {&a.samples, &b.samples});
  const double plane_excess = both.plane_chi2 - fit_a.plane_chi2 - fit_b.plane_chi2;
  const double quadratic_excess = both.quadratic_chi2 - fit_a.quadratic_chi2 - fit_b.quadratic_chi2;
  return plane_excess > kSignificance * tolerance.inflation && quadratic_excess < kFanRatio * plane_excess &&
         quadratic_excess < kFanMisfit * (tolerance.inflation * both.points +
                                          tolerance.sigma_distance * tolerance.sigma_distance * both.weight);
}

// Whether neighbours are turned against each other by more than an angle [rad], and not as the sides of an edge.
bool isTurned(const SampledRegion& a, const SampledRegion& b, double min_angle) {
  const double cosine = a.plane.normal.dot(b.plane.normal);
  return cosine < std::cos(min_angle) && cosine > 0.6;
}

// Two strips of a fan: well turned against each other, or each bent by about as much as they are.
bool isFan(const SampledRegion& a, const SampledRegion& b, const CoplanarityTolerance& tolerance, double max_turn) {
  // A scrap beside a large plane proves nothing about the plane.
  if (a.points > kFanSizes * b.points || b.points > kFanSizes * a.points) return false;
  if (!isTurned(a, b, kNarrowAngle * max_turn)) return false;
  const double angle = std::acos(std::min(1.0, a.plane.normal.dot(b.plane.normal)));
  const auto bends = [&](const Bend& bend) {
    return bend.turn > kNarrowTurn * angle && radiusOf(bend) < kNarrowRadius &&
           bend.excess > kSignificance * tolerance.inflation;
  };
  return (isTurned(a, b, kFanAngle * max_turn) || (bends(a.bend) && bends(b.bend))) && isSmooth(a, b, tolerance);
}

// Root mean square distance of samples from a plane, their noise taken out [m].
double misfit(const Plane& plane, const std::vector<Sample>& samples) {
  double sum = 0.0;
  for (const Sample& sample : samples) {
    const double distance = plane.signedDistance(sample.point);
    sum += distance * distance - sample.sigma * sample.sigma;
  }
  return std::sqrt(std::max(0.0, sum / static_cast<double>(std::max<std::size_t>(1, samples.size()))));
}

// Samples of every label of at least three points; index = label.
std::vector<SampledRegion> sampleRegions(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise,
                                         int threads) {
  std::vector<int> count(static_cast<std::size_t>(highestLabel(labels)) + 1, 0);
  forEachRun(labels, [&](std::int32_t label, int begin, int end) { count[label] += end - begin; });
  std::vector<std::vector<int>> pixels(count.size());
  std::vector<int> next(count.size(), 0);  // pixels of the label until the next sample
  forEachRun(labels, [&](std::int32_t label, int begin, int end) {
    const int stride = std::max(1, count[label] / kMaxSamples);
    int i = begin + next[label];
    for (; i < end; i += stride) {
      if (grid.valid(i)) pixels[label].push_back(i);
    }
    next[label] = i - end;
  });
  std::vector<SampledRegion> regions(count.size());
  forEachRange(threads, static_cast<int>(count.size()), [&](int begin, int end) {
    for (int label = begin; label < end; ++label) {
      if (pixels[label].size() < 3) continue;
      const int stride = std::max(1, count[label] / kMaxSamples);
      regions[label] = sampleRegion(grid, label, count[label], stride, pixels[label], noise);
      regions[label].bend = bendOf(fitQuadratic(regions[label].plane.normal, {&regions[label].samples}));
    }
  });
  return regions;
}

}  // namespace

std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  std::vector<Bend> bends;
  for (const SampledRegion& region : sampleRegions(grid, labels, noise, 1)) bends.push_back(region.bend);
  return bends;
}

void dropCurvedRegions(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                       LabelImage& labels, int threads) {
  const std::vector<SampledRegion> regions = sampleRegions(grid, labels, noise, threads);
  std::vector<bool> curved(regions.size(), false), weak(regions.size(), false);
  for (std::size_t label = 1; label < regions.size(); ++label) {
    const Bend& bend = regions[label].bend;
    weak[label] = bend.turn > kWeakTurn * max_turn && bend.amplitude > kWeakAmplitude * tolerance.sigma_distance &&
                  bend.excess > kSignificance * tolerance.inflation;
    curved[label] = weak[label] && bend.turn > max_turn && bend.amplitude > kMinAmplitude * tolerance.sigma_distance;
  }
  const std::vector<bool> alone = curved;
  const auto touching = touchingLabels(labels, 2);
  for (const auto& [a, b] : touching) {
    if (!(alone[a] && alone[b]) && isFan(regions[a], regions[b], tolerance, max_turn)) curved[a] = curved[b] = true;
  }
  // A strip that bends less, but beside a curved one of about its size, is more of the same surface.
  const std::vector<bool> certain = curved;
  for (const auto& [first, second] : touching) {
    if (certain[first] == certain[second]) continue;
    const std::int32_t strip = certain[first] ? second : first, beside = certain[first] ? first : second;
    if (regions[strip].points >= kStripSizes * regions[beside].points) continue;
    const SampledRegion &a = regions[strip], &b = regions[beside];
    if (weak[strip] || (isTurned(a, b, kNarrowAngle * max_turn) && isSmooth(a, b, tolerance))) curved[strip] = true;
  }
  // A bent strip along a larger plane that it hardly leaves is the soft edge of that plane.
  std::vector<std::int32_t> renamed(regions.size());
  for (std::size_t label = 0; label < regions.size(); ++label) {
    renamed[label] = curved[label] ? 0 : static_cast<std::int32_t>(label);
  }
  std::vector<int> host_points(regions.size(), 0);
  for (const auto& [a, b] : touching) {
    for (const auto& [strip, host] : {std::pair(a, b), std::pair(b, a)}) {
      if (!alone[strip] || curved[host]) continue;
      const SampledRegion& plane = regions[host];
      if (plane.points <= std::max(host_points[strip], regions[strip].points)) continue;
      if (misfit(plane.plane, regions[strip].samples) > kEdgeTolerance * tolerance.sigma_distance) continue;
      host_points[strip] = plane.points;
      renamed[strip] = host;
    }
  }
  renameLabels(renamed, labels);
}

}  // namespace ppc
