// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/same_image.h"

#include <gtest/gtest.h>
#include <functional>
#include <limits>
#include <vector>

namespace ppc {
namespace {

RangeImageMsg image() {
  RangeImageMsg m;
  m.header.stamp = ros::Time(10.0);
  m.header.frame_id = "tilt_base";
  m.height = 2;
  m.width = 2;
  m.ranges = {1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2.0F};
  m.tilts = {0.0F, 0.1F};
  m.row_stamps = {ros::Time(9.0), ros::Time(9.5)};
  m.poses_per_row = 1;
  m.line_poses.resize(2);
  return m;
}

TEST(SameImage, InvalidRangesEqualThemselvesAndAccountsDoNotMatter) {
  RangeImageMsg other = image();
  other.header.seq = 7;
  other.lines.lines_in = 300;
  EXPECT_TRUE(isSameImage(image(), other));
}

TEST(SameImage, AnythingThatIsMeasuredMatters) {
  const std::vector<std::function<void(RangeImageMsg&)>> changes = {
      [](auto& m) { m.header.stamp = ros::Time(11.0); },
      [](auto& m) { m.header.frame_id = "map"; },
      [](auto& m) { m.height = 1; },
      [](auto& m) { m.width = 4; },
      [](auto& m) { m.bearing_min = 0.1F; },
      [](auto& m) { m.bearing_increment = 0.1F; },
      [](auto& m) { m.range_min = 0.1F; },
      [](auto& m) { m.range_max = 0.1F; },
      [](auto& m) { m.poses_per_row = 2; },
      [](auto& m) { m.ranges[3] = 2.0001F; },
      [](auto& m) { m.ranges.push_back(1.0F); },
      [](auto& m) { m.intensities.push_back(1.0F); },
      [](auto& m) { m.tilts[1] = 0.2F; },
      [](auto& m) { m.row_stamps[1] = ros::Time(9.6); },
      [](auto& m) { m.line_poses[1].position.z = 1e-9; },
      [](auto& m) { m.line_poses[0].orientation.x = 1e-9; },
      [](auto& m) { m.line_poses.pop_back(); },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    RangeImageMsg other = image();
    changes[i](other);
    EXPECT_FALSE(isSameImage(image(), other)) << "change " << i;
    EXPECT_FALSE(isSameImage(other, image())) << "change " << i;
  }
}

}  // namespace
}  // namespace ppc
