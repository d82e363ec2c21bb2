// SPDX-License-Identifier: BSD-3-Clause
// Scans of analytic surfaces, and seeded noise, shared by the tests of the core.
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/plane.h"
#include "patch_plane_clustering/core/range_image.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace ppc::testing_tools {

constexpr double kDegree = M_PI / 180.0;
constexpr double kNoHit = std::numeric_limits<double>::infinity();
constexpr float kNoRange = std::numeric_limits<float>::quiet_NaN();

/// A nodding scan: x forward, y left, z up; tilt is a rotation about y, positive down. All ranges NaN.
inline RangeImage noddingScan(int rows, int cols, double tilt_min, double tilt_max, double bearing_max,
                              const Eigen::Vector3d& lever_arm = Eigen::Vector3d::Zero()) {
  RangeImage image;
  image.rows = rows;
  image.cols = cols;
  image.bearing_min = -bearing_max;
  image.bearing_increment = cols > 1 ? 2.0 * bearing_max / (cols - 1) : 0.0;
  image.range_min = 0.01;
  image.range_max = 100.0;
  image.ranges.assign(static_cast<std::size_t>(rows) * cols, kNoRange);
  for (int r = 0; r < rows; ++r) {
    const double tilt = rows > 1 ? tilt_min + r * (tilt_max - tilt_min) / (rows - 1) : tilt_min;
    Eigen::Isometry3d pose(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()));
    pose.translation() = pose.linear() * lever_arm;
    image.line_poses.push_back(pose);
    image.tilts.push_back(tilt);
  }
  return image;
}

/// The beams of a scan straight ahead with a step of `step` [rad] both ways; no ranges yet.
inline BeamGrid forwardBeams(int rows, int cols, double step) {
  return toBeamGrid(noddingScan(rows, cols, -0.5 * (rows - 1) * step, 0.5 * (rows - 1) * step, 0.5 * (cols - 1) * step));
}

/// Distance along a beam (origin, unit direction) to a surface [m]; kNoHit if it misses.
using Surface = std::function<double(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

/// A face of a scene: a plane, and which of its points belong to it.
struct Face {
  Plane plane;
  std::function<bool(const Eigen::Vector3d&)> contains;
};

inline Surface surfaceOf(const Face& face) {
  return [face](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double t = face.plane.rangeAlong(origin, direction);
    return t > 0.01 && face.contains(origin + t * direction) ? t : kNoHit;
  };
}

/// The plane normal . p = d without bounds; the normal need not be a unit vector.
inline Surface wall(const Eigen::Vector3d& normal, double d) {
  return surfaceOf({{normal.normalized(), d / normal.norm()}, [](const Eigen::Vector3d&) { return true; }});
}

/// A wall across the x axis that is nearly flat: `depth` gives its x at every y.
template <typename F>
Surface relief(F depth) {
  return [depth](const Eigen::Vector3d&, const Eigen::Vector3d& u) {
    double t = depth(0.0) / u.x();
    for (int k = 0; k < 6; ++k) t = depth(t * u.y()) / u.x();
    return t;
  };
}

/// The outside of a ball.
inline Surface ball(const Eigen::Vector3d& center, double radius) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Vector3d o = origin - center;
    const double b = o.dot(direction), root = b * b - o.squaredNorm() + radius * radius;
    return root >= 0.0 && b < 0.0 ? -b - std::sqrt(root) : kNoHit;
  };
}

/// The outside of an upright cylinder about (x, y).
inline Surface column(double x, double y, double radius) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Vector2d o(origin.x() - x, origin.y() - y), u = direction.head<2>();
    const double a = u.squaredNorm(), b = o.dot(u), c = o.squaredNorm() - radius * radius;
    const double root = b * b - a * c;
    return root >= 0.0 && b < 0.0 ? (-b - std::sqrt(root)) / a : kNoHit;
  };
}

/// Measures the nearest surface along every beam, without noise. @return labels 1.. in the order of the surfaces.
inline LabelImage scan(const std::vector<Surface>& surfaces, BeamGrid& grid) {
  LabelImage labels{grid.rows, grid.cols, std::vector<std::int32_t>(static_cast<std::size_t>(grid.size()), 0)};
  for (int i = 0; i < grid.size(); ++i) {
    double nearest = kNoHit;
    const Eigen::Vector3d origin = grid.origin(i).cast<double>(), direction = grid.direction(i).cast<double>();
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      const double t = surfaces[s](origin, direction);
      if (!(t < nearest)) continue;
      nearest = t;
      labels.labels[i] = static_cast<std::int32_t>(s) + 1;
    }
    if (labels.labels[i] > 0) grid.range[i] = static_cast<float>(nearest);
  }
  return labels;
}

inline LabelImage scanFaces(const std::vector<Face>& faces, BeamGrid& grid) {
  std::vector<Surface> surfaces;
  for (const Face& face : faces) surfaces.push_back(surfaceOf(face));
  return scan(surfaces, grid);
}

/// A wall three metres ahead, label 1, and a pane in it, label 2.
inline LabelImage scanPane(const Plane& pane, BeamGrid& grid) {
  const auto in_pane = [](const Eigen::Vector3d& p) { return std::abs(p.y() + 0.2) < 0.4 && std::abs(p.z()) < 0.35; };
  const auto in_wall = [=](const Eigen::Vector3d& p) { return !in_pane(p); };
  return scan({surfaceOf({{-Eigen::Vector3d::UnitX(), -3.0}, in_wall}), surfaceOf({pane, in_pane})}, grid);
}

/// A pane that lies `depth` behind the wall.
inline LabelImage scanPaneBehind(double depth, BeamGrid& grid) {
  return scanPane({-Eigen::Vector3d::UnitX(), -3.0 - depth}, grid);
}

/// Standard normal numbers, the same with every standard library (its distributions are not).
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }  ///< in [0, 1)
  double operator()() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }

 private:
  std::mt19937_64 engine_;
};

/// Adds range noise of sigma + relative * range; `correlation` is that of neighbouring beams of a line.
inline void addNoise(BeamGrid& grid, double sigma, double relative = 0.0, double correlation = 0.0, std::uint64_t seed = 1) {
  Normal normal(seed);
  for (int r = 0; r < grid.rows; ++r) {
    double error = normal();
    for (int c = 0; c < grid.cols; ++c) {
      const double range = grid.range[grid.index(r, c)];
      grid.range[grid.index(r, c)] = static_cast<float>(range + (sigma + relative * range) * error);
      error = correlation * error + std::sqrt(1.0 - correlation * correlation) * normal();
    }
  }
}

/// Adds range noise that is alike over a Gaussian of `width` pixels, as that of stereo cameras is.
inline void addSmoothNoise(BeamGrid& grid, double sigma, double width, std::uint64_t seed = 1) {
  Normal normal(seed);
  std::vector<double> errors(static_cast<std::size_t>(grid.size())), blurred(errors.size());
  for (double& error : errors) error = normal();
  const int reach = static_cast<int>(4.0 * width);
  for (const auto& [down, right] : {std::pair(0, 1), std::pair(1, 0)}) {
    for (int i = 0; i < grid.size(); ++i) {
      double sum = 0.0;
      for (int k = -reach; k <= reach; ++k) {
        const int row = std::clamp(i / grid.cols + k * down, 0, grid.rows - 1);
        const int col = std::clamp(i % grid.cols + k * right, 0, grid.cols - 1);
        sum += std::exp(-0.5 * k * k / (width * width)) * errors[grid.index(row, col)];
      }
      blurred[i] = sum;
    }
    errors.swap(blurred);
  }
  double squares = 0.0;
  for (const double error : errors) squares += error * error;
  const double scale = sigma / std::sqrt(squares / static_cast<double>(errors.size()));
  for (int i = 0; i < grid.size(); ++i) grid.range[i] += static_cast<float>(scale * errors[i]);
}

/// Number of pixels with a label.
inline int countOf(const LabelImage& labels, std::int32_t label) {
  int count = 0;
  for (const std::int32_t l : labels.labels) count += l == label ? 1 : 0;
  return count;
}

}  // namespace ppc::testing_tools
