// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/joint_sample.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

sensor_msgs::JointState message() {
  sensor_msgs::JointState m;
  m.header.stamp = ros::Time(12.5);
  m.name = {"wheel", "tilt"};
  m.position = {7.0, -0.25};
  return m;
}

TEST(JointSample, isFoundByName) {
  const JointSample sample = readJointSample(message(), "tilt");
  EXPECT_TRUE(sample.present);
  EXPECT_EQ(sample.fault, "");
  EXPECT_EQ(sample.stamp, 12.5);
  EXPECT_EQ(sample.angle, -0.25);
  EXPECT_FALSE(readJointSample(message(), "pan").present);
}

TEST(JointSample, whatIsIncompleteIsNamed) {
  sensor_msgs::JointState m = message();
  m.position.pop_back();  // whose is missing?
  EXPECT_EQ(readJointSample(m, "tilt").fault, "as many joint positions as names expected (1 and 2)");
  EXPECT_EQ(readJointSample(m, "wheel").fault, "as many joint positions as names expected (1 and 2)");
  m = message();
  m.header.stamp = ros::Time();
  EXPECT_EQ(readJointSample(m, "tilt").fault, "joint sample without stamp");
  m = message();
  m.name[0] = "tilt";  // which of the two angles?
  EXPECT_EQ(readJointSample(m, "tilt").fault, "joint 'tilt' is there twice in one message");
}

}  // namespace
}  // namespace ppc
