// SPDX-License-Identifier: BSD-3-Clause
// The nodelet's topics against the simulator that it is made of.
#include "patch_plane_clustering/sim/scanner.h"
#include "ros_test_main.h"
#include "wait_for.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>
#include <cmath>
#include <cstring>

namespace ppc {
namespace {

constexpr double kStart = 1000.0;  // of the simulator's clock [s]
constexpr int kLines = 40;

template <typename Message>
struct Collector {
  explicit Collector(const std::string& topic) {
    subscriber =
        node.subscribe<Message>(topic, 1000, [this](const boost::shared_ptr<const Message>& m) { all.push_back(m); });
  }
  ros::NodeHandle node;
  std::vector<boost::shared_ptr<const Message>> all;
  ros::Subscriber subscriber;
};

sim::Scanner twin() {
  sim::ScannerOptions options;
  options.motion.lines_per_pass = kLines;
  options.mount = sim::mountFrom({0.0, 0.0, 0.08}, Eigen::Vector3d::Zero());
  return sim::Scanner(sim::makeScene("box", 1), options, 1);
}

TEST(SimulatedScanner, PublishesWhatTheScannerMeasures) {
  Collector<sensor_msgs::LaserScan> scans("scan");
  Collector<sensor_msgs::JointState> joints("joint_states");
  Collector<tf2_msgs::TFMessage> transforms("/tf");
  Collector<rosgraph_msgs::Clock> clock("/clock");
  ASSERT_TRUE(waitFor([&] { return scans.all.size() > 100 && joints.all.size() > 200; }));
  const sim::Scanner scanner = twin();

  for (const auto& scan : scans.all) {
    const int index = static_cast<int>(std::lround((scan->header.stamp.toSec() - kStart) / scanner.lineDuration()));
    EXPECT_NEAR(scan->header.stamp.toSec(), kStart + index * scanner.lineDuration(), 1e-6);
    EXPECT_EQ(scan->header.frame_id, "laser");
    ASSERT_EQ(scan->ranges, scanner.line(index % (2 * kLines)).ranges) << "line " << index;
    EXPECT_NEAR(scan->angle_max, 135.0 * M_PI / 180.0, 1e-5);
    EXPECT_NEAR(scan->time_increment, scanner.timeIncrement(), 1e-9);
  }
  for (const auto& joint : joints.all) {
    ASSERT_EQ(joint->name, std::vector<std::string>{"tilt_joint"});
    const double t = joint->header.stamp.toSec() - kStart;
    EXPECT_NEAR(joint->position.at(0), scanner.options().motion.tilt(t, scanner.passDuration()), 1e-6);
  }
  ASSERT_FALSE(transforms.all.empty());
  for (const auto& message : transforms.all) {
    const auto& t = message->transforms.at(0);
    EXPECT_EQ(t.header.frame_id, "tilt_base");
    EXPECT_EQ(t.child_frame_id, "laser");
    const double tilt = scanner.options().motion.tilt(t.header.stamp.toSec() - kStart, scanner.passDuration());
    EXPECT_NEAR(t.transform.rotation.y, std::sin(0.5 * tilt), 1e-6);
    EXPECT_NEAR(t.transform.translation.x, 0.08 * std::sin(tilt), 1e-6);
  }
  ASSERT_GT(clock.all.size(), 100U);
  for (std::size_t i = 1; i < clock.all.size(); ++i) EXPECT_GE(clock.all[i]->clock, clock.all[i - 1]->clock);
}

TEST(SimulatedScanner, PublishesTheTruthOfEachPass) {
  Collector<sensor_msgs::Image> truths("ground_truth/labels");
  ASSERT_TRUE(waitFor([&] { return truths.all.size() >= 2; }));
  const sim::Scanner scanner = twin();
  for (const auto& truth : truths.all) {
    const int last = static_cast<int>(std::lround((truth->header.stamp.toSec() - kStart) / scanner.lineDuration()));
    EXPECT_EQ(truth->header.frame_id, "tilt_base");
    EXPECT_EQ(truth->encoding, "32SC1");
    ASSERT_EQ(truth->data.size(), kLines * 1081 * sizeof(std::int32_t));
    const sim::Sweep sweep = scanner.sweep((last / kLines) % 2);
    std::vector<std::int32_t> labels(kLines * 1081);
    std::memcpy(labels.data(), truth->data.data(), truth->data.size());
    EXPECT_EQ(labels, sweep.labels.labels);
  }
}

TEST(SimulatedScanner, WrongParametersKeepItFromStarting) {
  ros::master::V_TopicInfo topics;
  ASSERT_TRUE(ros::master::getTopics(topics));
  bool right = false;
  for (const auto& topic : topics) {
    right = right || topic.name == "/scan";
    EXPECT_NE(topic.name, "/wrong/scan");
  }
  EXPECT_TRUE(right);
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_simulated_scanner"); }
