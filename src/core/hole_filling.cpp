// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/hole_filling.h"

#include "patch_plane_clustering/core/label_runs.h"

#include <cmath>

namespace ppc {
namespace {

constexpr double kMaxMean = 4.0;     // mean distance of a speck, in standard deviations of such a mean
constexpr double kMaxScatter = 6.0;  // mean square of its distances, in variances of noise and tolerance

// A point against a plane.
struct Residual {
  double distance;   // along the beam [m]
  double variance;   // of the noise
  double tolerance;  // variance of the tolerance
};

}  // namespace

void fillHoles(const BeamGrid& grid, const std::vector<Eigen::Vector3d>& planes, const Eigen::Vector3d& center,
               const NoiseModel& noise, const CoplanarityTolerance& tolerance, int smallest, LabelImage& labels) {
  std::vector<int> points(planes.size(), 0);
  forEachRun(labels, [&](std::int32_t label, int begin, int end) { points[label] += end - begin; });
  std::vector<char> loose(points.size());  // labels, and none, that are not those of a region
  for (std::size_t label = 0; label < loose.size(); ++label) loose[label] = label == 0 || points[label] < smallest ? 1 : 0;

  const auto residual = [&](int i, const Eigen::Vector3d& a) {
    const double along = a.dot(grid.direction(i).cast<double>());
    const double across = 1.0 + a.dot(center) - a.dot(grid.origin(i).cast<double>());
    const double range = grid.range[i];
    const double sigma = noise.sigma(range), floor = tolerance.forNoise(sigma).sigma_distance;
    const double sec2 = std::min(30.0, a.squaredNorm() / (along * along));
    return Residual{range - across / along, sigma * sigma, floor * floor * sec2};
  };
  std::vector<char> seen(static_cast<std::size_t>(grid.size()), 0);
  std::vector<int> speck;
  const auto fillFrom = [&](int first) {
    if (seen[first] != 0 || !grid.valid(first)) return;
    speck.assign(1, first);
    seen[first] = 1;
    std::int32_t around = 0;
    bool alone = true;
    for (std::size_t k = 0; k < speck.size(); ++k) {
      const int i = speck[k], row = i / grid.cols, col = i % grid.cols;
      const auto visit = [&](int j) {
        if (!grid.valid(j)) return;
        if (loose[labels.labels[j]] == 0) {
          alone = alone && (around == 0 || around == labels.labels[j]);
          around = labels.labels[j];
        } else if (seen[j] == 0) {
          seen[j] = 1;
          speck.push_back(j);
        }
      };
      if (col > 0) visit(i - 1);
      if (col + 1 < grid.cols) visit(i + 1);
      if (row > 0) visit(i - grid.cols);
      if (row + 1 < grid.rows) visit(i + grid.cols);
    }
    if (around == 0 || !alone || static_cast<int>(speck.size()) >= smallest) return;
    double sum = 0.0, squares = 0.0, variances = 0.0, allowed = 0.0;
    for (const int i : speck) {
      const Residual r = residual(i, planes[around]);
      const double standard = r.variance + r.tolerance;
      sum += r.distance;
      squares += r.distance * r.distance / standard;
      variances += r.variance;
      allowed += r.tolerance;
    }
    const auto n = static_cast<double>(speck.size());
    const double deviation = std::sqrt(variances / n * std::min(1.0, tolerance.inflationOf(n) / n) + allowed / n);
    if (std::abs(sum / n) > kMaxMean * deviation || squares / n > kMaxScatter) return;
    for (const int i : speck) labels.labels[i] = around;
  };
  for (int begin = 0, end = 0; begin < grid.size(); begin = end) {
    end = runEnd(labels.labels.data(), begin, grid.size());
    if (loose[labels.labels[begin]] == 0) continue;
    for (int i = begin; i < end; ++i) fillFrom(i);
  }
}

}  // namespace ppc
