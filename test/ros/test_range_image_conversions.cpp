// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace ppc {
namespace {

const float kInf = std::numeric_limits<float>::infinity();
const float kNaN = std::numeric_limits<float>::quiet_NaN();

RangeImage smallImage() {
  RangeImage image;
  image.rows = 2;
  image.cols = 3;
  image.bearing_min = -0.5;
  image.bearing_increment = 0.5;
  image.range_min = 0.1;
  image.range_max = 30.0;
  image.ranges = {1.0F, 2.0F, kInf, kNaN, -kInf, 6.0F};
  image.intensities = {1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F};
  image.poses_per_row = 2;
  for (int i = 0; i < 4; ++i) {
    image.line_poses.push_back(Eigen::Translation3d(0.1 * i, 0.2, -0.3) *
                               Eigen::AngleAxisd(0.25 * i, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  }
  image.tilts = {0.0, 0.5};
  image.row_stamps = {1000.25, 1000.5};
  return image;
}

std_msgs::Header header() {
  std_msgs::Header h;
  h.stamp = ros::Time(1000.75);
  h.frame_id = "tilt_base";
  return h;
}

sensor_msgs::LaserScan smallScan() {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(5.0);
  scan.header.frame_id = "laser";
  scan.angle_min = -1.0F;
  scan.angle_max = 1.0F;
  scan.angle_increment = 0.5F;
  scan.time_increment = 0.001F;
  scan.range_min = 0.1F;
  scan.range_max = 5.6F;
  scan.ranges = {1.0F, 2.0F, 3.0F, 4.0F, 5.0F};
  return scan;
}

TEST(RangeImageConversions, aMessageHoldsTheImage) {
  const RangeImage image = smallImage();
  const RangeImageMsg message = toMessage(image, header());
  EXPECT_EQ(message.header.frame_id, "tilt_base");
  EXPECT_EQ(message.header.stamp, ros::Time(1000.75));
  EXPECT_EQ(message.row_stamps[1], ros::Time(1000.5));
  const RangeImage back = fromMessage(message);
  EXPECT_EQ(back.rows, 2);
  EXPECT_EQ(back.cols, 3);
  EXPECT_EQ(back.poses_per_row, 2);
  EXPECT_NEAR(back.bearing(2.0), 0.5, 1e-6);
  EXPECT_NEAR(back.range_min, 0.1, 1e-6);
  EXPECT_EQ(back.range_max, 30.0);
  EXPECT_EQ(std::memcmp(back.ranges.data(), image.ranges.data(), 6 * sizeof(float)), 0);
  EXPECT_EQ(back.intensities, image.intensities);
  EXPECT_EQ(back.tilts, image.tilts);
  EXPECT_EQ(back.row_stamps, image.row_stamps);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(back.line_poses[i].matrix().isApprox(image.line_poses[i].matrix(), 1e-12)) << i;
  }
}

TEST(RangeImageConversions, aWrongMessageIsRefusedByName) {
  const auto complaint = [](void (*spoil)(RangeImageMsg&)) {
    RangeImageMsg message = toMessage(smallImage(), header());
    spoil(message);
    try {
      fromMessage(message);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  const auto names = [&](const char* word, void (*spoil)(RangeImageMsg&)) {
    EXPECT_NE(complaint(spoil).find(word), std::string::npos) << complaint(spoil);
  };
  names("ranges", [](RangeImageMsg& m) { m.ranges.pop_back(); });
  names("intensities", [](RangeImageMsg& m) { m.intensities.pop_back(); });
  names("line_poses", [](RangeImageMsg& m) { m.line_poses.pop_back(); });
  names("quaternion", [](RangeImageMsg& m) { m.line_poses[1].orientation.w = kNaN; });
  names("quaternion", [](RangeImageMsg& m) { m.line_poses[0].orientation = geometry_msgs::Quaternion(); });
  names("pose", [](RangeImageMsg& m) { m.line_poses[1].position.x = kInf; });
  names("pose", [](RangeImageMsg& m) { m.line_poses[0].position.z = -1e300; });
  names("1000 km", [](RangeImageMsg& m) { m.line_poses[1].position.y = 4e31; });
  names("1000 km", [](RangeImageMsg& m) { m.line_poses[0].position.x = -1.1e6; });
  names("height", [](RangeImageMsg& m) { m.height = 4000000000U; });
  names("empty", [](RangeImageMsg& m) { m.width = 0; });
  names("poses_per_row", [](RangeImageMsg& m) { m.poses_per_row = 0; });
  names("bearing", [](RangeImageMsg& m) { m.bearing_increment = kNaN; });
  names("range_m", [](RangeImageMsg& m) { m.range_max = kNaN; });
}

TEST(RangeImageConversions, theCloudIsOrganisedAndKeepsNaN) {
  const RangeImage image = smallImage();
  const sensor_msgs::PointCloud2 cloud = toPointCloud(image, header());
  EXPECT_EQ(cloud.height, 2U);
  EXPECT_EQ(cloud.width, 3U);
  EXPECT_FALSE(cloud.is_dense);
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2ConstIterator<float> intensity(cloud, "intensity");
  for (std::size_t i = 0; i < 6; ++i, ++x, ++intensity) {
    EXPECT_EQ(std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]), i == 0 || i == 1 || i == 5) << i;
    EXPECT_EQ(*intensity, static_cast<float>(i + 1));
    if (i != 0 && i != 5) continue;
    const Eigen::Isometry3d& pose = image.line_poses[i == 0 ? 0 : 3];
    const double bearing = image.bearing(i == 0 ? 0 : 2);
    const Eigen::Vector3d p = pose * (image.ranges[i] * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0));
    EXPECT_LT((p.cast<float>() - Eigen::Vector3f(x[0], x[1], x[2])).norm(), 1e-5F);
  }
}

TEST(RangeImageConversions, withoutIntensitiesTheCloudHasNone) {
  RangeImage image = smallImage();
  image.intensities.clear();
  const sensor_msgs::PointCloud2 cloud = toPointCloud(image, header());
  EXPECT_EQ(cloud.fields.size(), 3U);
  EXPECT_EQ(cloud.data.size(), 6U * 12U);
}

TEST(RangeImageConversions, theRadialImageHoldsTheRangesAsTheyAre) {
  const sensor_msgs::Image message = toRadialImage(smallImage(), header());
  EXPECT_EQ(message.encoding, "32FC1");
  EXPECT_EQ(message.step, 12U);
  EXPECT_EQ(message.height, 2U);
  ASSERT_EQ(message.data.size(), 24U);
  float value = 0.0F;
  std::memcpy(&value, &message.data[8], 4);
  EXPECT_EQ(value, kInf);
}

TEST(RangeImageConversions, aScanBecomesALine) {
  sensor_msgs::LaserScan scan = smallScan();
  ScanLine line = toScanLine(scan, -0.25);
  EXPECT_EQ(faultOf(line), "");
  EXPECT_EQ(line.stamp, 4.75);
  EXPECT_NEAR(line.lastStamp(), 4.754, 1e-6);
  EXPECT_EQ(line.ranges, scan.ranges);
  scan.header.stamp = ros::Time();
  EXPECT_NE(faultOf(toScanLine(scan, 1.0)).find("stamp"), std::string::npos);
  scan.range_max = kInf;  // +Inf must stay "no return"
  EXPECT_FALSE(isValidRange(kInf, line.range_min, toScanLine(scan).range_max));
}

TEST(RangeImageConversions, theNumberOfBeamsMustFitTheAngles) {
  sensor_msgs::LaserScan scan = smallScan();
  EXPECT_EQ(faultOf(scan), "");
  scan.angle_max = 1.5F;  // some drivers give the end of the last step
  EXPECT_EQ(faultOf(scan), "");
  scan.angle_max = 2.0F;
  EXPECT_NE(faultOf(scan), "");
  scan = smallScan();
  std::swap(scan.angle_min, scan.angle_max);
  EXPECT_NE(faultOf(scan), "");
  scan.angle_increment = -0.5F;  // upside down
  EXPECT_EQ(faultOf(scan), "");
  scan.angle_max = kNaN;
  EXPECT_NE(faultOf(scan), "");
}

TEST(RangeImageConversions, aStampThatRosCannotHoldIsZero) {
  EXPECT_EQ(toTime(-1.0), ros::Time());
  EXPECT_EQ(toTime(1e12), ros::Time());
  EXPECT_EQ(toTime(std::numeric_limits<double>::quiet_NaN()), ros::Time());
  EXPECT_EQ(toTime(2.5), ros::Time(2, 500000000));
}

}  // namespace
}  // namespace ppc
