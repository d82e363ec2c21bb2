// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/curvature.h"

#include "patch_plane_clustering/core/region_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace patch_plane_clustering {
namespace {

constexpr int kMaxSamples = 1500;
constexpr double kSignificance = 25.0;   // far beyond chi-square with 3 degrees of freedom
constexpr double kMinAmplitude = 0.5;    // of a bend, in tolerances of distance
constexpr double kFanAngle = 0.7;        // smallest angle between two strips of a fan, in max_turn
constexpr int kFanSizes = 6;              // largest ratio of their sizes
constexpr double kFanRatio = 0.15;       // misfit of one quadratic surface over that of one plane, for two strips of a fan
constexpr double kFanMisfit = 0.1;       // the same misfit per point, in units of the noise variance
constexpr double kEdgeTolerance = 3.0;   // of a bent edge of a plane, in tolerances of distance
constexpr double kUniformWidth = 3.46;  // width of a uniform distribution over its standard deviation

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Samples of a region: where, how far along the beams, how precise across the surface.
struct Sample {
  Eigen::Vector3d point;
  double sigma;   // across the region's plane [m]
  double weight;  // pixels it stands for
};

std::vector<Sample> takeSamples(const BeamGrid& grid, const PlanarRegion& region, const std::vector<int>& pixels,
                                const NoiseModel& noise) {
  std::vector<Sample> samples;
  const int stride = std::max(1, static_cast<int>(pixels.size()) / kMaxSamples);
  samples.reserve(pixels.size() / stride + 1);
  for (std::size_t k = 0; k < pixels.size(); k += stride) {
    const int i = pixels[k];
    const Eigen::Vector3d p = grid.point(i).cast<double>();
    const double cosine = std::max(0.1, -region.plane.normal.dot(grid.direction(i).cast<double>()));
    const double sigma = noise.sigma(grid.range[i]) * cosine;
    if (std::abs(region.plane.signedDistance(p)) > 4.0 * std::max(sigma, region.rms)) continue;
    samples.push_back({p, sigma, static_cast<double>(stride)});
  }
  return samples;
}

// Least-squares plane and quadratic surface z(s, t) of samples over a given tangent frame.
struct QuadraticFit {
  double plane_chi2 = 0.0, quadratic_chi2 = 0.0;
  double weight = 0.0;       // sum of 1 / sigma^2 [1/m^2]
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
      Vector6 terms;
      terms << 1.0, s, t, s * s, s * t, t * t;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(terms, w);
      right += w * z * terms;
      total += w * z * z;
      fit.weight += w;
      fit.points += sample.weight;
      fit.scatter += w * Eigen::Vector2d(s, t) * Eigen::Vector2d(s, t).transpose();
    }
  }
  normal = Matrix6(normal.selfadjointView<Eigen::Lower>());
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

// Pairs of labels that are 4-neighbours in the image, or parted by up to `gap` pixels.
std::set<std::pair<std::int32_t, std::int32_t>> touchingLabels(const LabelImage& labels, int gap) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  const auto meet = [&](std::int32_t a, std::int32_t b) {
    if (b > 0 && a != b) pairs.emplace(std::min(a, b), std::max(a, b));
  };
  for (int r = 0; r < labels.rows; ++r) {
    for (int c = 0; c < labels.cols; ++c) {
      const std::size_t i = static_cast<std::size_t>(r) * labels.cols + c;
      const std::int32_t label = labels.labels[i];
      if (label == 0) continue;
      for (int g = 1; g <= gap + 1; ++g) {
        if (c + g < labels.cols && labels.labels[i + g] != label) meet(label, labels.labels[i + g]);
        if (r + g < labels.rows && labels.labels[i + static_cast<std::size_t>(g) * labels.cols] != label) {
          meet(label, labels.labels[i + static_cast<std::size_t>(g) * labels.cols]);
        }
      }
    }
  }
  return pairs;
}

// One smooth surface serves both as well as two of their own would, one plane does not: strips of a fan.
bool isFan(const PlanarRegion& a, const PlanarRegion& b, const std::vector<Sample>& samples_a,
           const std::vector<Sample>& samples_b, const CoplanarityTolerance& tolerance, double max_turn) {
  // A scrap beside a large plane proves nothing about the plane.
  if (a.points > kFanSizes * b.points || b.points > kFanSizes * a.points) return false;
  const double cosine = a.plane.normal.dot(b.plane.normal);
  if (cosine > std::cos(kFanAngle * max_turn) || cosine < 0.6) return false;
  const Eigen::Vector3d n = (a.points * a.plane.normal + b.points * b.plane.normal).normalized();
  const QuadraticFit fit_a = fitQuadratic(n, {&samples_a});
  const QuadraticFit fit_b = fitQuadratic(n, {&samples_b});
  const QuadraticFit both = fitQuadratic(n, {&samples_a, &samples_b});
  const double plane_excess = both.plane_chi2 - fit_a.plane_chi2 - fit_b.plane_chi2;
  const double quadratic_excess = both.quadratic_chi2 - fit_a.quadratic_chi2 - fit_b.quadratic_chi2;
  return plane_excess > kSignificance * tolerance.inflation && quadratic_excess < kFanRatio * plane_excess &&
         quadratic_excess < kFanMisfit * tolerance.inflation * both.points;
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

struct RegionSamples {
  std::vector<PlanarRegion> regions;
  std::vector<std::vector<Sample>> samples;  // of each region
};

RegionSamples sampleRegions(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  RegionSamples out;
  out.regions = describeRegions(grid, labels);
  const std::int32_t highest = out.regions.empty() ? 0 : out.regions.back().id;
  std::vector<std::vector<int>> pixels(static_cast<std::size_t>(highest) + 1);
  for (const PlanarRegion& region : out.regions) pixels[region.id].reserve(region.points);
  for (int i = 0; i < grid.size(); ++i) {
    const std::int32_t label = labels.labels[i];
    if (label > 0 && label <= highest && grid.valid(i)) pixels[label].push_back(i);
  }
  for (const PlanarRegion& region : out.regions) {
    out.samples.push_back(takeSamples(grid, region, pixels[region.id], noise));
  }
  return out;
}

}  // namespace

std::vector<Bend> measureBends(const BeamGrid& grid, const LabelImage& labels, const NoiseModel& noise) {
  const RegionSamples all = sampleRegions(grid, labels, noise);
  std::vector<Bend> bends(all.regions.empty() ? 1 : static_cast<std::size_t>(all.regions.back().id) + 1);
  for (std::size_t k = 0; k < all.regions.size(); ++k) {
    bends[all.regions[k].id] = bendOf(fitQuadratic(all.regions[k].plane.normal, {&all.samples[k]}));
  }
  return bends;
}

void dropCurvedRegions(const BeamGrid& grid, const NoiseModel& noise, const CoplanarityTolerance& tolerance, double max_turn,
                       LabelImage& labels) {
  const RegionSamples all = sampleRegions(grid, labels, noise);
  // Labels of fewer than three points have no region.
  std::size_t size = 1;
  for (const std::int32_t label : labels.labels) size = std::max(size, static_cast<std::size_t>(label) + 1);
  std::vector<int> index(size, -1);
  std::vector<bool> curved(size, false);
  for (std::size_t k = 0; k < all.regions.size(); ++k) {
    index[all.regions[k].id] = static_cast<int>(k);
    const Bend bend = bendOf(fitQuadratic(all.regions[k].plane.normal, {&all.samples[k]}));
    curved[all.regions[k].id] = bend.turn > max_turn && bend.amplitude > kMinAmplitude * tolerance.sigma_distance &&
                                bend.excess > kSignificance * tolerance.inflation;
  }
  const std::vector<bool> alone = curved;
  const auto touching = touchingLabels(labels, 2);
  for (const auto& [a, b] : touching) {
    if (index[a] < 0 || index[b] < 0 || (alone[a] && alone[b])) continue;
    if (isFan(all.regions[index[a]], all.regions[index[b]], all.samples[index[a]], all.samples[index[b]], tolerance, max_turn)) {
      curved[a] = curved[b] = true;
    }
  }
  // A bent strip along a larger plane that it hardly leaves is the soft edge of that plane.
  std::vector<std::int32_t> renamed(size);
  for (std::size_t label = 0; label < size; ++label) {
    renamed[label] = curved[label] || index[label] < 0 ? 0 : static_cast<std::int32_t>(label);
  }
  std::vector<int> host_points(size, 0);
  for (const auto& [a, b] : touching) {
    for (const auto& [strip, host] : {std::pair(a, b), std::pair(b, a)}) {
      if (index[strip] < 0 || index[host] < 0 || !alone[strip] || curved[host]) continue;
      const PlanarRegion& plane = all.regions[index[host]];
      if (plane.points <= std::max(host_points[strip], all.regions[index[strip]].points)) continue;
      if (misfit(plane.plane, all.samples[index[strip]]) > kEdgeTolerance * tolerance.sigma_distance) continue;
      host_points[strip] = plane.points;
      renamed[strip] = host;
    }
  }
  for (std::int32_t& label : labels.labels) {
    label = renamed[label];
  }
}

}  // namespace patch_plane_clustering
