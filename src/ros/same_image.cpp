// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/same_image.h"

#include <cstring>
#include <type_traits>
#include <vector>

namespace ppc {
namespace {

template <typename T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

bool isSameImage(const RangeImageMsg& a, const RangeImageMsg& b) {
  return a.header.stamp == b.header.stamp && a.header.frame_id == b.header.frame_id && a.height == b.height &&
         a.width == b.width && a.bearing_min == b.bearing_min && a.bearing_increment == b.bearing_increment &&
         a.range_min == b.range_min && a.range_max == b.range_max && a.poses_per_row == b.poses_per_row &&
         a.row_stamps == b.row_stamps && sameBytes(a.tilts, b.tilts) && sameBytes(a.ranges, b.ranges) &&
         sameBytes(a.intensities, b.intensities) && a.line_poses == b.line_poses;
}

}  // namespace ppc
