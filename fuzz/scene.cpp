// SPDX-License-Identifier: BSD-3-Clause
#include "scene.h"

#include <cmath>
#include <limits>

namespace ppc::fuzz {
namespace {

// A part of a plane as the image shows it.
struct Face {
  Eigen::Vector3d normal;
  double d;
  int row, col, rows, cols;                      // its box
  int hole_row, hole_col, hole_rows, hole_cols;  // and a hole in it

  bool covers(int r, int c) const {
    const auto within = [](int at, int from, int n) { return at >= from && at < from + n; };
    return within(r, row, rows) && within(c, col, cols) &&
           !(within(r, hole_row, hole_rows) && within(c, hole_col, hole_cols));
  }
};

Face takeFace(Input& input, const BeamGrid& grid) {
  const double elevation = input.real(-1.6, 1.6), azimuth = input.real(-3.2, 3.2);
  Face face;
  face.normal = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
  face.d = input.real(0.05, 10.0);
  face.row = input.integer(0, grid.rows - 1);
  face.col = input.integer(0, grid.cols - 1);
  face.rows = input.integer(1, grid.rows);
  face.cols = input.integer(1, grid.cols);
  face.hole_row = input.integer(0, grid.rows - 1);
  face.hole_col = input.integer(0, grid.cols - 1);
  face.hole_rows = input.integer(0, grid.rows / 2);
  face.hole_cols = input.integer(0, grid.cols / 2);
  return face;
}

}  // namespace

Config takeConfig(Input& input) {
  Config config;
  config.min_size = 12;
  for (const ConfigField& field : configFields()) {
    if (!input.flag()) continue;
    const double high = field.type == ConfigField::Type::kInt ? std::min(field.max, field.min + 60.0) : field.max;
    const double value = input.real(field.min, high);
    field.set(config, field.type == ConfigField::Type::kDouble ? value : std::round(value));
  }
  return config;
}

RangeImage takeScan(Input& input) {
  RangeImage image;
  image.rows = input.integer(1, 24);
  image.cols = input.integer(1, 32);
  image.poses_per_row = input.integer(1, 4);
  const double width = input.real(0.01, 6.3);
  const double sign = input.flag() ? -1.0 : 1.0;
  image.bearing_min = -0.5 * sign * width;
  image.bearing_increment = sign * width / std::max(1, image.cols - 1);
  image.range_min = input.real(0.0, 0.5);
  image.range_max = input.real(0.5, 60.0);
  const double first = input.real(-1.6, 1.6), span = input.real(0.0, 3.2), during_row = input.real(-0.05, 0.05);
  const Eigen::Vector3d arm(input.real(-0.3, 0.3), input.real(-0.3, 0.3), input.real(-0.3, 0.3));
  const bool lever_arm = input.flag();
  for (int r = 0; r < image.rows; ++r) {
    const double tilt = first + span * r / std::max(1, image.rows - 1);
    image.tilts.push_back(tilt);
    image.row_stamps.push_back(1000.0 + 0.025 * r);
    for (int k = 0; k < image.poses_per_row; ++k) {
      Eigen::Isometry3d pose(Eigen::AngleAxisd(tilt + during_row * k, Eigen::Vector3d::UnitY()));
      if (lever_arm) pose.translation() = pose.linear() * arm;
      image.line_poses.push_back(pose);
    }
  }
  image.ranges.assign(static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.cols),
                      std::numeric_limits<float>::quiet_NaN());
  return image;
}

std::vector<float> takeRanges(Input& input, const BeamGrid& grid) {
  constexpr float kMissed[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 3.0F, -1.0F};
  std::vector<float> ranges(static_cast<std::size_t>(grid.size()), kMissed[input.integer(0, 3)]);
  std::uint32_t random = input.raw<std::uint32_t>();
  const double noise = input.flag() ? input.real(0.0, 0.1) : 0.0;
  std::vector<Face> faces(static_cast<std::size_t>(input.integer(0, 4)));
  for (Face& face : faces) face = takeFace(input, grid);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const int i = grid.index(r, c);
      const Eigen::Vector3d origin = grid.origin(i).cast<double>(), direction = grid.direction(i).cast<double>();
      double nearest = std::numeric_limits<double>::infinity();
      for (const Face& face : faces) {
        const double range = (face.d - face.normal.dot(origin)) / face.normal.dot(direction);
        if (range > 0.0 && range < nearest && face.covers(r, c)) nearest = range;
      }
      random = random * 1664525U + 1013904223U;
      if (std::isfinite(nearest)) {
        nearest += noise * (static_cast<double>(random >> 8) / 16777216.0 - 0.5);
        ranges[static_cast<std::size_t>(i)] = static_cast<float>(nearest);
      }
    }
  }
  // What is left of the input goes into single pixels, as it is.
  while (input.remaining() >= 6) {
    const auto pixel = input.raw<std::uint16_t>() % ranges.size();
    ranges[pixel] = input.raw<float>();
  }
  return ranges;
}

}  // namespace ppc::fuzz
