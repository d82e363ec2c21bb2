// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/range_image.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

[[noreturn]] void fail(const std::string& what) { throw std::invalid_argument("range image: " + what); }

// The text becomes a string only if it is needed: there is one check a pose.
void require(bool ok, const char* what) {
  if (!ok) fail(what);
}

void requireSize(std::size_t actual, std::size_t expected, const char* name) {
  if (actual == expected) return;
  fail(std::string(name) + " has " + std::to_string(actual) + " elements, expected " + std::to_string(expected));
}

}  // namespace

void checkConsistent(const RangeImage& image) {
  if (image.rows <= 0 || image.cols <= 0) {
    fail("is empty (" + std::to_string(image.rows) + " rows, " + std::to_string(image.cols) + " columns)");
  }
  if (image.poses_per_row < 1) fail("poses_per_row is " + std::to_string(image.poses_per_row) + ", must be at least 1");
  const auto rows = static_cast<std::size_t>(image.rows);
  const auto pixels = rows * static_cast<std::size_t>(image.cols);
  requireSize(image.ranges.size(), pixels, "ranges");
  if (!image.intensities.empty()) requireSize(image.intensities.size(), pixels, "intensities");
  if (!image.tilts.empty()) requireSize(image.tilts.size(), rows, "tilts");
  if (!image.row_stamps.empty()) requireSize(image.row_stamps.size(), rows, "row_stamps");
  requireSize(image.line_poses.size(), rows * static_cast<std::size_t>(image.poses_per_row), "line_poses");
  require(std::isfinite(image.bearing_min) && std::isfinite(image.bearing_increment), "bearings are not finite");
  require(image.bearing_increment != 0.0 || image.cols == 1, "bearing_increment is zero");
  if (!(image.range_min <= image.range_max)) {
    fail("range_min " + std::to_string(image.range_min) + " exceeds range_max " + std::to_string(image.range_max) +
         ", or one of them is NaN");
  }
  for (const auto& pose : image.line_poses) {
    require(pose.matrix().cast<float>().allFinite(), "a line pose is not finite");  // beams are in single precision
  }
}

}  // namespace ppc
