// SPDX-License-Identifier: BSD-3-Clause
// Input that is odd though no field of it is wrong, and a system that is: lasers upside down, of one beam, with a cap on;
// clocks that disagree; requests without end; a manager that is suspended. All this with simulated time and no clock.
#include "fault_rig.h"
#include "stray.h"

#include <std_srvs/Trigger.h>
#include <csignal>
#include <limits>

namespace ppc {
namespace {

using OddInput = FaultRig;

constexpr double kStart = 10000.0;

TEST_F(OddInput, aLaserUpsideDownSeesTheSameRoom) {
  player.send_scan = [&](auto scan) {  // its beams go the other way round
    std::reverse(scan.ranges.begin(), scan.ranges.end());
    std::reverse(scan.intensities.begin(), scan.intensities.end());
    std::swap(scan.angle_min, scan.angle_max);
    scan.angle_increment *= -1.0F;
    player.publishScan(scan);
  };
  player.time_increment = 0.0F;
  start();
  player.play(kStart, kStart + 6.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_LT(player.images[0]->bearing_increment, 0.0F);
  EXPECT_GE(polygons.back()->polygons.size(), 4U);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, linesWithoutExtentMakeImagesWithoutPlanes) {
  player.beams = 1;
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  EXPECT_EQ(player.images[1]->width, 1U);
  EXPECT_NEAR(player.images[1]->height, 80, 3);
  expectAccountsClose();
  const std::size_t thin = player.images.size();
  player.beams = 121;
  player.play(kStart + 4.4, kStart + 10.4);
  ASSERT_TRUE(waitForImages(thin + 3));
  ASSERT_TRUE(
      waitFor([&] { return !statistics.empty() && statistics.back()->header.stamp == player.images.back()->header.stamp; }));
  expectAccountsClose();
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
  EXPECT_GE(polygons.back()->polygons.size(), 4U);
  // Too narrow for a patch: refused, and counted; so are what came of the last thin lines.
  EXPECT_GE(statistics.back()->images_refused, thin);
  EXPECT_EQ(statistics.back()->images_received,
            polygons.size() + statistics.back()->images_refused + statistics.back()->images_overtaken);
}

TEST_F(OddInput, aCapOnTheLensGivesEmptyArraysNotSilence) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<float> nothing = {nan, inf, -inf, 0.0F};
  std::size_t n = 0;
  player.send_scan = [&](auto scan) {
    std::fill(scan.ranges.begin(), scan.ranges.end(), nothing[n++ / 80 % nothing.size()]);
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 8.4);
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_GE(polygons.size() + statistics.back()->images_overtaken, 4U);
  for (const auto& array : polygons) EXPECT_TRUE(array->polygons.empty());
  EXPECT_EQ(statistics.back()->valid_points, 0U);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, intensitiesThatComeAndGoCostNothing) {
  std::size_t n = 0;
  player.send_scan = [&](auto scan) {
    if (++n % 3 == 0) scan.intensities.clear();
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  for (const auto& image : player.images) EXPECT_TRUE(image->intensities.empty());
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, twoLayoutsInTurnMakeNoSweepAndAreTold) {
  std::size_t n = 0;
  bool in_turn = true;
  player.send_scan = [&](auto scan) {
    if (in_turn && ++n % 2 == 0) {
      scan.ranges.resize(60);
      scan.intensities.resize(60);
      scan.angle_max = scan.angle_min + 59.0F * scan.angle_increment;
    }
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 4.0);
  ASSERT_TRUE(told("the scan's layout changed"));
  EXPECT_TRUE(player.images.empty());
  in_turn = false;
  player.play(kStart + 4.0, kStart + 10.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_NEAR(drops("sweep too small"), 160.0, 3.0);
  EXPECT_EQ(player.linesDropped(), drops("sweep too small"));
}

TEST_F(OddInput, aJointWithAnotherClockMovesNoRow) {
  double from = kStart;
  start();
  for (const double shift : {1e6, -9000.0, 30.0, -30.0}) {
    std::string told;  // while lines come
    player.send_joint = [&](auto sample) {
      sample.header.stamp += ros::Duration(shift);
      player.publishJoint(sample);
      if (player.diagnostics.level != diagnostic_msgs::DiagnosticStatus::OK) told = player.diagnostics.message;
    };
    player.play(from, from + 8.0);
    EXPECT_TRUE(told.find("lines dropped") != std::string::npos || told.find("lines wait") != std::string::npos)
        << "by " << shift << " s: " << told;
    ASSERT_TRUE(settle());
    from += 8.0;
  }
  EXPECT_TRUE(player.images.empty());
  player.send_joint = [&](const auto& sample) { player.publishJoint(sample); };
  player.play(from, from + 8.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_GE(player.linesDropped(), 4.0 * 320.0 - 1.0);
}

TEST_F(OddInput, requestsToCloseTheSweepWithoutEndLoseNoLineUncounted) {
  start();
  ros::ServiceClient close = nh_.serviceClient<std_srvs::Trigger>(ns_ + "/close_sweep");
  std::size_t n = 0, closed = 0;
  player.send_scan = [&](const auto& scan) {
    player.publishScan(scan);
    if (++n % 7 != 0) return;
    std_srvs::Trigger call;
    ASSERT_TRUE(close.call(call));
    closed += call.response.success ? 1 : 0;
  };
  player.play(kStart, kStart + 4.4);
  player.send_scan = [&](const auto& scan) { player.publishScan(scan); };
  player.play(kStart + 4.4, kStart + 10.4);
  ASSERT_TRUE(waitForImages(closed + 3));
  expectSound();
  EXPECT_EQ(player.linesDropped(), drops("sweep too small"));
  EXPECT_GT(drops("sweep too small"), 50);
}

TEST_F(OddInput, aTopicOfAnotherTypeDisturbsNobody) {
  start();
  const Stray words(ns_ + "/scan", "std_msgs/String", "{data: a scan}");
  const Stray more_words(ns_ + "/joint_states", "std_msgs/String", "{data: a joint}");
  const Stray image(ns_ + "/points_in", "sensor_msgs/LaserScan", "{}");
  ASSERT_TRUE(words.runs() && more_words.runs() && image.runs());
  player.play(kStart, kStart + 16.4);
  ASSERT_TRUE(waitForImages(7));
  expectSound();
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, aManagerThatWasSuspendedGoesOnAndCountsWhatItMissed) {
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  const pid_t process = managerProcess();
  ASSERT_GT(process, 0);
  ASSERT_EQ(kill(process, SIGSTOP), 0);
  player.play(kStart + 4.4, kStart + 44.4);  // 1600 lines, 4000 joint samples: more than any queue holds
  ASSERT_EQ(kill(process, SIGCONT), 0);
  player.play(kStart + 44.4, kStart + 52.4);
  ASSERT_TRUE(waitFor([&] {
    return !player.images.empty() && player.images.back()->header.stamp.toSec() > kStart + 48.0 &&
           player.diagnosed("Lines in") + player.diagnosed("Scans lost on the way") == player.scans_sent;
  }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
  EXPECT_GT(player.diagnosed("Scans lost on the way"), 0.0);
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnosed("Lines in"),
            player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test_odd_input");
  ros::start();
  return RUN_ALL_TESTS();
}
