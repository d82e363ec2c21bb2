// SPDX-License-Identifier: BSD-3-Clause
// Input that is odd though no field of it is wrong, and a system that is: lasers upside down, of one beam, with a cap on;
// clocks that disagree; requests without end; a manager that is suspended. All this with simulated time and no clock.
#include "fault_rig.h"
#include "ros_test_main.h"
#include "stray.h"

#include <std_srvs/Trigger.h>
#include <csignal>
#include <limits>
#include <map>

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

TEST_F(OddInput, oneStampForAllScansMakesOneLineAndIsTold) {
  player.send_scan = [&](auto scan) {
    scan.header.stamp = ros::Time(kStart + 1.0);
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 4.0);
  ASSERT_TRUE(settle());
  EXPECT_EQ(drops("duplicate stamp"), player.scans_sent - 1);
  EXPECT_TRUE(player.images.empty());
  player.send_scan = [&](const auto& scan) { player.publishScan(scan); };
  player.play(kStart + 4.0, kStart + 10.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
}

TEST_F(OddInput, aJointThatIsTwiceInOneMessageMovesNoRow) {
  std::size_t n = 0;
  player.send_joint = [&](auto sample) {
    if (++n % 4 == 0) {  // which of the two?
      sample.name.insert(sample.name.begin(), "tilt_joint");
      sample.position.insert(sample.position.begin(), sample.position.back() + 0.01);
    }
    player.publishJoint(sample);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_EQ(player.diagnosed("Joint messages rejected: incomplete"), static_cast<double>(n / 4));
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, framesWithASlashAsTfWroteThemAreTheSame) {
  set("driver/base_frame", "/" + ns_.substr(1) + "_base");
  set("driver/laser_frame", "/" + ns_.substr(1) + "_laser");
  std::size_t n = 0;
  player.send_scan = [&](auto scan) {
    if (++n % 2 == 0) scan.header.frame_id.insert(0, "/");
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_EQ(player.images[0]->header.frame_id, ns_.substr(1) + "_base");
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, nodeletsLoadedTwiceOnTheSameTopicsGiveAllTwiceAndTheSame) {
  start();
  for (const char* parameter : {"joint_name", "base_frame"}) {
    std::string value;
    ASSERT_TRUE(ros::param::get(ns_ + "/driver/" + parameter, value));
    set(std::string("other_driver/") + parameter, value);
  }
  set("other_driver/lever_arm", std::vector<double>{0.05, -0.01, 0.08});
  NodeletManager manager("/manager");
  ASSERT_TRUE(manager.load(ns_ + "/other_driver", "TiltScanDriver"));
  player.play(kStart, kStart + 6.4);
  ASSERT_TRUE(waitForImages(6));
  ASSERT_TRUE(settle());
  std::map<ros::Time, std::vector<RangeImageMsg::ConstPtr>> twins;
  for (const auto& image : player.images) twins[image->header.stamp].push_back(image);
  std::size_t both = 0;
  for (const auto& [stamp, images] : twins) {
    ASSERT_LE(images.size(), 2U);
    if (images.size() < 2) continue;  // the second had not yet heard of the first lines
    ++both;
    EXPECT_EQ(images[0]->ranges, images[1]->ranges);
    EXPECT_EQ(images[0]->tilts, images[1]->tilts);
  }
  EXPECT_GE(both, 2U);
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(OddInput, aNodeletThatWouldHearItselfDoesNotListen) {
  std::map<std::string, std::string> onto_each_other = {{ns_ + "/points_in", ns_ + "/loop"},
                                                        {ns_ + "/segmented_points", ns_ + "/loop"}};
  NodeletManager manager("/manager");
  ASSERT_TRUE(manager.load(ns_ + "/loop_ppc", "PatchPlaneClustering", onto_each_other));
  start();
  std::string told;
  std::size_t clouds = 0;
  const auto diagnostics = nh_.subscribe<diagnostic_msgs::DiagnosticArray>("/diagnostics", 50, [&](const auto& array) {
    for (const auto& status : array->status) {
      if (status.name == ns_.substr(1) + "/loop_ppc: plane clustering") told = status.message;
    }
  });
  const auto loop = nh_.subscribe<sensor_msgs::PointCloud2>(ns_ + "/loop", 50, [&](const auto&) { ++clouds; });
  ASSERT_TRUE(waitFor([&] { return told.find("points_in and segmented_points are both") != std::string::npos; })) << told;
  ASSERT_TRUE(waitFor([&] { return loop.getNumPublishers() > 0; }));
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  ASSERT_TRUE(waitFor([&] { return clouds >= 2; }));
  player.play(kStart + 4.4, kStart + 5.4);
  EXPECT_LE(clouds, player.images.size());  // one for each image, none for a cloud
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
  player.play(kStart + 4.4, kStart + 44.4);  // 1600 lines, 4000 joint samples: more than our queues hold
  ASSERT_EQ(kill(process, SIGCONT), 0);
  player.play(kStart + 44.4, kStart + 52.4);
  ASSERT_TRUE(waitFor([&] {
    return !player.images.empty() && player.images.back()->header.stamp.toSec() > kStart + 48.0 &&
           player.diagnosed("Lines in") + player.diagnosed("Scans lost on the way") == player.scans_sent;
  }));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
  // How many were lost is the kernel's affair, whose buffers may hold them all; that each is counted was waited for.
  ASSERT_TRUE(player.freshDiagnostics());
  EXPECT_EQ(player.diagnosed("Lines in"),
            player.diagnosed("Lines in images") + player.diagnosed("Lines pending") + player.linesDropped());
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_odd_input"); }
