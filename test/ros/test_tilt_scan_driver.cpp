// SPDX-License-Identifier: BSD-3-Clause
#include "ros_test_main.h"
#include "scan_player.h"

#include <gtest/gtest.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <std_srvs/Trigger.h>
#include <limits>

namespace ppc {
namespace {

// Largest distance of a cloud's points from the room's walls; `base_in_room` is the cloud's frame in the room.
double worstPoint(const sensor_msgs::PointCloud2& cloud,
                  const Eigen::Isometry3d& base_in_room = Eigen::Isometry3d::Identity()) {
  double worst = 0.0;
  for (sensor_msgs::PointCloud2ConstIterator<float> p(cloud, "x"); p != p.end(); ++p) {
    worst = std::max(worst, offTheWalls(base_in_room * Eigen::Vector3d(p[0], p[1], p[2])));
  }
  return worst;
}

bool ascending(const std::vector<float>& tilts) { return std::is_sorted(tilts.begin(), tilts.end()); }

void nodding(ScanPlayer& player) { player.mount.translation() = Eigen::Vector3d(0.05, -0.01, 0.08); }

// Each test lives in its own stretch of time, so that one driver can serve several tests.
constexpr double kBase = 10000.0;

TEST(TiltScanDriver, noddingPutsEveryPointOnTheWalls) {
  ScanPlayer player("/nod");
  nodding(player);
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 6.4);
  ASSERT_TRUE(waitFor([&] { return player.images.size() >= 3 && player.clouds.size() >= 3; }));
  for (std::size_t i = 0; i < 3; ++i) {
    const RangeImageMsg& image = *player.images[i];
    EXPECT_EQ(image.header.frame_id, "nod_base");
    EXPECT_EQ(image.width, 121U);
    EXPECT_NEAR(image.height, 80, 3);
    EXPECT_TRUE(ascending(image.tilts));
    EXPECT_NEAR(image.tilts.front(), -0.7, 0.01);
    EXPECT_NEAR(image.tilts.back(), 0.7, 0.01);
    EXPECT_EQ(image.intensities[5 * 121 + 17], 17.0F);
    const auto newest = std::max_element(image.row_stamps.begin(), image.row_stamps.end());
    EXPECT_NEAR((image.header.stamp - *newest).toSec(), 0.015, 1e-6);

    const sensor_msgs::PointCloud2& cloud = *player.clouds[i];
    EXPECT_EQ(cloud.height, image.height);
    EXPECT_EQ(cloud.width, image.width);
    EXPECT_EQ(cloud.header.stamp, image.header.stamp);
    EXPECT_LT(worstPoint(cloud), 0.001);

    const sensor_msgs::Image& radial = *player.radials[i];
    EXPECT_EQ(radial.encoding, "32FC1");
    EXPECT_EQ(radial.step, 121U * 4U);
    float range = 0.0F;
    std::memcpy(&range, &radial.data[4 * 1000], 4);
    EXPECT_EQ(range, image.ranges[1000]);
  }
}

TEST(TiltScanDriver, upAndDownGiveTheSameImageOfAStillScene) {
  ScanPlayer player("/nod");
  nodding(player);
  player.time_increment = 0.0F;  // each line at one instant, so that both ways see the very same beams
  const double start = kBase + 100.0;
  // The motor turns midway between two lines: their tilts are mirrored in time.
  player.tilt = [=](double t) { return 0.7 - 0.4 * std::abs(std::fmod(t - start + 35.0 + 0.0125, 7.0) - 3.5); };
  ASSERT_TRUE(player.connect());
  player.play(start, start + 8.0);
  ASSERT_TRUE(waitFor([&] { return player.images.size() >= 2; }));
  const RangeImageMsg& up = *player.images[player.images.size() - 2];
  const RangeImageMsg& down = *player.images.back();
  EXPECT_EQ(up.height, 140U);
  ASSERT_EQ(up.height, down.height);
  EXPECT_LT(up.row_stamps.front(), up.row_stamps.back());
  EXPECT_GT(down.row_stamps.front(), down.row_stamps.back());
  for (std::size_t r = 0; r < up.height; ++r) ASSERT_NEAR(up.tilts[r], down.tilts[r], 1e-5) << "row " << r;
  for (std::size_t i = 0; i < up.ranges.size(); ++i) ASSERT_NEAR(up.ranges[i], down.ranges[i], 2e-4) << "pixel " << i;
}

TEST(TiltScanDriver, halfTurnsOfASpinningLaser) {
  ScanPlayer player("/spin");
  player.axis = Eigen::Vector3d::UnitX();
  player.mount = Eigen::Translation3d(0.1, 0.02, 0.03) * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  player.tilt = [](double t) { return 2.0 * (t - kBase) - 1.0; };
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 6.0);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 3; }));
  for (std::size_t i = 1; i < 3; ++i) {  // the first one began within a half turn
    const RangeImageMsg& image = *player.images[i];
    EXPECT_NEAR(image.height, M_PI / 2.0 * 40.0, 1.5);
    EXPECT_TRUE(ascending(image.tilts));
    EXPECT_NEAR(image.tilts.front(), i == 1 ? 0.0 : -M_PI, 0.06);
    EXPECT_NEAR(image.tilts.back() - image.tilts.front(), M_PI, 0.06);
    EXPECT_LT(worstPoint(*player.clouds[i]), 0.001);
  }
}

TEST(TiltScanDriver, tiltFromTfAlone) {
  ScanPlayer player("/tf_only");
  player.with_joint = false;
  player.with_tf = true;
  player.mount.translation() = Eigen::Vector3d(0.02, 0.0, 0.08);
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(player.images[i]->height, 80, 3);
    EXPECT_NEAR(player.images[i]->tilts.front(), -0.7, 0.01);
    EXPECT_NEAR(player.images[i]->tilts.back(), 0.7, 0.01);
    EXPECT_LT(worstPoint(*player.clouds[i]), 0.001);
  }
}

TEST(TiltScanDriver, mountFromTf) {
  ScanPlayer player("/mounted");
  player.with_tf = true;
  player.mount.translation() = Eigen::Vector3d(0.0, 0.0, 0.08);
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  EXPECT_LT(worstPoint(*player.clouds[0]), 0.001);
  EXPECT_LT(worstPoint(*player.clouds[1]), 0.001);
  const RangeImageMsg& image = *player.images[0];
  const std::size_t middle = (image.height / 2) * image.poses_per_row + image.poses_per_row / 2;
  const double tilt = image.tilts[image.height / 2];
  EXPECT_NEAR(image.line_poses[middle].position.x, 0.08 * std::sin(tilt), 1e-5);
  EXPECT_NEAR(image.line_poses[middle].position.z, 0.08 * std::cos(tilt), 1e-5);
  ASSERT_TRUE(player.freshDiagnostics());
  for (const auto& value : player.diagnostics.values) {
    if (value.key != "Mount of the laser") continue;
    EXPECT_NE(value.value.find("0.0800] m"), std::string::npos) << value.value;
  }
}

TEST(TiltScanDriver, withoutTfTheMountIsZeroAfterATimeOut) {
  ScanPlayer player("/unmounted");
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  EXPECT_NEAR(player.images[0]->height, 80, 3);  // no line was lost while it waited
  EXPECT_LT(worstPoint(*player.clouds[0]), 0.001);
}

TEST(TiltScanDriver, aDrivingBaseIsCompensated) {
  ScanPlayer player("/driving");
  player.mount.translation() = Eigen::Vector3d(0.0, 0.0, 0.08);
  player.with_base_motion = true;
  player.basePose = [](double t) {
    return Eigen::Isometry3d(Eigen::Translation3d(0.3 * (t - kBase) - 1.0, 0.1 * (t - kBase), 0.0)) *
           Eigen::AngleAxisd(0.1 * (t - kBase), Eigen::Vector3d::UnitZ());
  };
  ASSERT_TRUE(player.connect());
  player.play(kBase, kBase + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  for (const auto& cloud : player.clouds) {
    // Seen from where the base was at the newest beam, all is in one room.
    EXPECT_LT(worstPoint(*cloud, player.basePose(cloud->header.stamp.toSec())), 0.001);
    EXPECT_GT(worstPoint(*cloud), 0.05);
  }
}

TEST(TiltScanDriver, linesWithoutJointSamplesAreDroppedAndCounted) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 200.0;
  player.silent = [=](double t) { return t > start + 0.6 && t < start + 1.4; };
  ASSERT_TRUE(player.connect());
  ASSERT_TRUE(player.freshDiagnostics());
  const double gaps = player.diagnosed("Lines dropped: tilt gap");
  player.play(start, start + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_NEAR(player.diagnosed("Lines dropped: tilt gap") - gaps, 0.8 * 40.0, 3.0);
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.001);
  EXPECT_EQ(player.diagnosed("Lines in"),
            player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
}

TEST(TiltScanDriver, badScansAreCountedAndTheDriverLivesOn) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 300.0;
  ASSERT_TRUE(player.connect());
  ASSERT_TRUE(player.freshDiagnostics());
  const double before = player.diagnosed("Lines dropped: bad scan");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::function<void(sensor_msgs::LaserScan&)>> faults = {
      [](auto& s) { s.ranges.clear(); },
      [](auto& s) { s.ranges.resize(60); },
      [](auto& s) { s.intensities.resize(7); },
      [nan](auto& s) { s.angle_increment = nan; },
      [](auto& s) { s.angle_increment = 0.0F; },
      [](auto& s) { s.angle_increment = -s.angle_increment; },
      [nan](auto& s) { s.angle_min = nan; },
      [nan](auto& s) { s.angle_max = nan; },
      [nan](auto& s) { s.time_increment = nan; },
      [](auto& s) { s.time_increment = -1e-4F; },
      [](auto& s) { std::swap(s.range_min, s.range_max); },
      [](auto& s) { s.header.stamp = ros::Time(); },
      [](auto& s) { s.header.frame_id = "elsewhere"; },
      [](auto& s) { s.header.frame_id.clear(); },
  };
  player.play(start, start + 0.5);
  for (const auto& spoil : faults) {
    sensor_msgs::LaserScan scan = player.scan(start + 0.5);
    spoil(scan);
    player.publishScan(scan);
  }
  player.play(start + 0.5, start + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnosed("Lines dropped: bad scan") - before, static_cast<double>(faults.size()));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.001);
}

TEST(TiltScanDriver, aSweepIsClosedOnRequest) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 400.4;
  ASSERT_TRUE(player.connect());
  player.play(start, start + 1.0);
  std_srvs::Trigger service;
  ros::WallDuration(0.3).sleep();  // the last lines are on their way
  ASSERT_TRUE(ros::service::call("/nod/close_sweep", service));
  EXPECT_TRUE(service.response.success) << service.response.message;
  // What an earlier test left open may come out before.
  const auto now = [&] { return !player.images.empty() && player.images.back()->header.stamp.toSec() > start; };
  ASSERT_TRUE(waitFor(now));
  EXPECT_NEAR(player.images.back()->height, 40, 2);
  EXPECT_EQ(service.response.message, "sweep of " + std::to_string(player.images.back()->height) + " lines closed");
  ASSERT_TRUE(ros::service::call("/nod/close_sweep", service));
  EXPECT_FALSE(service.response.success);
}

TEST(TiltScanDriver, anIdleSweepIsPublished) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 500.4;
  ASSERT_TRUE(player.connect());
  player.play(start, start + 1.0);
  const auto now = [&] { return !player.images.empty() && player.images.back()->header.stamp.toSec() > start; };
  EXPECT_FALSE(now());
  ASSERT_TRUE(waitFor(now, 6.0));
  EXPECT_NEAR(player.images.back()->height, 40, 2);
}

TEST(TiltScanDriver, diagnosticsTellOfAStandingTiltAndOfSilence) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 600.0;
  player.tilt = [](double) { return 0.3; };
  ASSERT_TRUE(player.connect());
  player.play(start, start + 5.0);
  ASSERT_TRUE(waitFor([&] { return player.diagnostics.message.find("tilt stands still") != std::string::npos; }))
      << player.diagnostics.message;
  ASSERT_TRUE(waitFor([&] { return player.diagnostics.level == diagnostic_msgs::DiagnosticStatus::ERROR; }));
  EXPECT_GE(player.diagnosed("Lines dropped: tilt standing"), 150.0);
  EXPECT_NE(player.diagnostics.message.find("no scans"), std::string::npos) << player.diagnostics.message;
  EXPECT_EQ(player.diagnosed("Lines in"),
            player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
  player.tilt = [=](double t) { return 0.3 + 0.3 * (t - start - 5.0); };
  player.play(start + 5.0, start + 8.0);
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnostics.message.find("tilt stands still"), std::string::npos) << player.diagnostics.message;
}

TEST(TiltScanDriver, aLoopingBagStartsAgain) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 700.0;
  ASSERT_TRUE(player.connect());
  player.play(start, start + 3.0);
  ASSERT_TRUE(waitFor([&] { return !player.clouds.empty(); }));
  const std::size_t before = player.clouds.size();
  player.play(start, start + 3.0);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() > before; }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.001);
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_GE(player.diagnosed("Clock resets"), 1.0);
}

TEST(TiltScanDriver, badJointMessagesAreCountedAndMoveNoRow) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 800.0;
  ASSERT_TRUE(player.connect());
  ASSERT_TRUE(player.freshDiagnostics());
  const auto counts = [&] {
    return std::vector<double>{
        player.diagnosed("Joint messages rejected: incomplete"), player.diagnosed("Joint samples rejected: not finite"),
        player.diagnosed("Joint samples rejected: not newer"), player.diagnosed("Joint samples rejected: implausible")};
  };
  const std::vector<double> before = counts();
  player.play(start, start + 1.0);
  sensor_msgs::JointState message;
  message.header.stamp = ros::Time(start + 0.992);
  message.name = {"other_joint", "tilt_joint"};
  message.position = {1.0};
  player.publishJoint(message);
  message.position = {1.0, 0.0};
  message.header.stamp = ros::Time();
  player.publishJoint(message);
  message.header.stamp = ros::Time(start + 0.992);
  message.position[1] = std::numeric_limits<double>::quiet_NaN();
  player.publishJoint(message);
  message.position[1] = 2.5;  // no motor is that fast
  player.publishJoint(message);
  message.header.stamp = ros::Time(start + 0.5);
  player.publishJoint(message);
  message.name = {"other_joint"};  // no business of ours
  message.position.clear();
  player.publishJoint(message);
  player.play(start + 1.0, start + 4.4);
  ASSERT_TRUE(waitFor([&] { return player.clouds.size() >= 2; }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.001);
  ASSERT_TRUE(player.freshDiagnostics());
  const std::vector<double> after = counts();
  EXPECT_EQ(after[0] - before[0], 2.0);
  EXPECT_EQ(after[1] - before[1], 1.0);
  EXPECT_EQ(after[2] - before[2], 1.0);
  EXPECT_EQ(after[3] - before[3], 1.0);
}

TEST(TiltScanDriver, aChangeOfTheBeamCountStartsANewSweep) {
  ScanPlayer player("/nod");
  nodding(player);
  const double start = kBase + 900.2;
  ASSERT_TRUE(player.connect());
  ASSERT_TRUE(player.freshDiagnostics());
  const double before = player.diagnosed("Layout changes");
  player.play(start, start + 0.8);
  player.beams = 61;
  player.play(start + 0.8, start + 2.4);
  const auto now = [&] { return !player.images.empty() && player.images.back()->width == 61; };
  ASSERT_TRUE(waitFor(now));
  ASSERT_GE(player.images.size(), 2U);
  const RangeImageMsg& first = *player.images[player.images.size() - 2];
  EXPECT_EQ(first.width, 121U);
  EXPECT_NEAR(first.height, 32, 2);
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.001);
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnosed("Layout changes") - before, 1.0);
}

TEST(TiltScanDriver, aBadParameterIsNamedAndTheDriverRefuses) {
  ScanPlayer player("/wrong");
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnostics.level, diagnostic_msgs::DiagnosticStatus::ERROR);
  for (const char* word : {"motion", "wobbling", "nodding", "spinning"}) {
    EXPECT_NE(player.diagnostics.message.find(word), std::string::npos) << player.diagnostics.message;
  }
  ros::master::V_TopicInfo topics;
  ASSERT_TRUE(ros::master::getTopics(topics));
  for (const auto& topic : topics) EXPECT_NE(topic.name, "/wrong/points");
}

TEST(TiltScanDriver, aMisspeltParameterIsReportedByName) {
  ScanPlayer player("/nod");
  ASSERT_TRUE(waitFor([&] { return !player.diagnostics.values.empty(); }));
  std::string reported;
  for (const auto& value : player.diagnostics.values) {
    if (value.key == "Unknown parameters") reported = value.value;
  }
  EXPECT_NE(reported.find("'/nod/driver/turn_hysterisis'"), std::string::npos) << reported;
  EXPECT_NE(reported.find("did you mean 'turn_hysteresis'"), std::string::npos) << reported;
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_tilt_scan_driver"); }
