// SPDX-License-Identifier: BSD-3-Clause
// Faults of sensor, joint and clock, injected on the topics; what is judged is what comes out.
#include "fault_rig.h"
#include "ros_test_main.h"
#include "stray.h"

#include <deque>
#include <limits>
#include <random>

namespace ppc {
namespace {

using SweepFaults = FaultRig;

constexpr double kStart = 10000.0;

/// The laser loses this share of its lines.
void drop(ScanPlayer& player, double share) {
  auto random = std::make_shared<std::mt19937>(7);
  player.send_scan = [=, &player](const auto& scan) {
    if (std::uniform_real_distribution<double>()(*random) >= share) player.publishScan(scan);
  };
}

TEST_F(SweepFaults, scanDropsLeaveSmallerImages) {
  start();
  double from = kStart;
  for (const double share : {0.01, 0.1, 0.5}) {
    drop(player, share);
    const std::size_t before = player.images.size();
    player.play(from, from + 8.4);  // two sweeps up, two down, a little more
    ASSERT_TRUE(waitForImages(before + 4));
    for (std::size_t i = before + 1; i < before + 4; ++i) {
      EXPECT_NEAR(player.images[i]->height, 80.0 * (1.0 - share), 3.0 + 30.0 * share);
    }
    from += 100.0;
  }
  expectSound();
  EXPECT_LE(drops("no tilt"), 3);  // where the clock leaps from one stretch to the next
  EXPECT_LE(drops("tilt gap"), 3);
  EXPECT_EQ(player.linesDropped(), drops("sweep too small") + drops("no tilt") + drops("tilt gap"));
}

TEST_F(SweepFaults, burstsAndReorderingPutEveryRowInPlace) {
  std::mt19937 random(3);
  std::vector<sensor_msgs::LaserScan> burst;
  player.send_scan = [&](const auto& scan) {
    burst.push_back(scan);
    if (burst.size() < 8) return;
    std::shuffle(burst.begin(), burst.end(), random);
    for (const auto& late : burst) player.publishScan(late);
    burst.clear();
  };
  start();
  player.play(kStart, kStart + 6.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_EQ(player.linesDropped(), drops("out of order"));
  EXPECT_GT(drops("out of order"), 20);
  EXPECT_GT(player.diagnosed("Lines in images"), 30.0);
}

TEST_F(SweepFaults, jointSamplesInBurstsLoseNothing) {
  std::vector<sensor_msgs::JointState> burst;
  player.send_joint = [&](const auto& sample) {
    burst.push_back(sample);
    if (burst.size() < 20) return;
    for (const auto& late : burst) player.publishJoint(late);
    burst.clear();
  };
  start();
  player.play(kStart, kStart + 6.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, duplicatedStampsAreCountedOneByOne) {
  int repeated = 0, n = 0;
  player.send_scan = [&](const auto& scan) {
    player.publishScan(scan);
    if (++n % 5 != 0) return;
    ++repeated;
    sensor_msgs::LaserScan other = scan;
    for (float& range : other.ranges) range += 0.5F;  // would be seen off the walls
    player.publishScan(other);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_EQ(drops("duplicate stamp"), repeated);
  EXPECT_EQ(player.linesDropped(), repeated);
}

/// Stamps as if the clock had been set by `step` at `when`; the motor and the room know nothing of it.
void setClock(ScanPlayer& player, double when, double step) {
  const auto shifted = [=](auto message) {
    if (message.header.stamp.toSec() >= when) message.header.stamp += ros::Duration(step);
    return message;
  };
  player.send_scan = [=, &player](const auto& scan) { player.publishScan(shifted(scan)); };
  player.send_joint = [=, &player](const auto& sample) { player.publishJoint(shifted(sample)); };
}

TEST_F(SweepFaults, aClockSetBackFarDropsTheOpenSweep) {
  setClock(player, kStart + 2.6, -500.0);
  start();
  player.play(kStart, kStart + 8.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_EQ(player.diagnosed("Clock resets"), 1.0);
  EXPECT_NEAR(drops("clock reset"), 24.0, 4.0);  // of the sweep that was open
  EXPECT_EQ(player.linesDropped(), drops("clock reset") + drops("no tilt") + drops("out of order"));
}

TEST_F(SweepFaults, aClockSetBackALittleCostsThatTime) {
  setClock(player, kStart + 2.6, -0.4);
  start();
  player.play(kStart, kStart + 8.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_NEAR(drops("out of order") + drops("duplicate stamp"), 16.0, 3.0);
  EXPECT_LE(player.linesDropped() - drops("out of order") - drops("duplicate stamp"), 3.0);
}

TEST_F(SweepFaults, aClockSetForwardEndsTheSweep) {
  setClock(player, kStart + 2.6, 1000.0);
  start();
  player.play(kStart, kStart + 8.4);
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_LE(player.linesDropped(), 4.0);
  EXPECT_NEAR(player.images[1]->height, 24, 2);
  EXPECT_LT(player.images[1]->header.stamp.toSec(), kStart + 3.0);
  EXPECT_GT(player.images[2]->header.stamp.toSec(), kStart + 1000.0);
}

TEST_F(SweepFaults, lateJointSamplesLoseNothing) {
  double late = 0.0;
  std::deque<sensor_msgs::JointState> waiting;
  player.send_joint = [&](const auto& sample) {
    waiting.push_back(sample);
    while (!waiting.empty() && waiting.front().header.stamp.toSec() <= sample.header.stamp.toSec() - late) {
      player.publishJoint(waiting.front());
      waiting.pop_front();
    }
  };
  start();
  double from = kStart;
  for (const double delay : {0.0, 0.1, 0.25, 0.5}) {
    late = delay;
    const std::size_t before = player.images.size();
    player.play(from, from + 4.0);
    ASSERT_TRUE(waitForImages(before + 1)) << delay;
    EXPECT_NEAR(player.images[before]->height, 80, 3) << delay;
    from += 4.0;
  }
  expectSound();
  EXPECT_GE(player.images.size(), 7U);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, aJointMissingForTwoSecondsCostsThoseLines) {
  player.silent = [](double t) { return t > kStart + 2.6 && t < kStart + 4.6; };
  start();
  player.play(kStart, kStart + 10.4);
  ASSERT_TRUE(waitForImages(5));
  expectSound();
  EXPECT_NEAR(drops("tilt gap") + drops("no tilt"), 80.0, 4.0);
  EXPECT_EQ(player.linesDropped(), drops("tilt gap") + drops("no tilt"));
}

TEST_F(SweepFaults, aFrozenJointCostsThoseLines) {
  double from = kStart;
  start();
  for (const double seconds : {0.3, 1.5, 4.0}) {
    sensor_msgs::JointState frozen;
    player.send_joint = [&](const auto& sample) {
      const double t = sample.header.stamp.toSec() - from;
      if (t < 2.6) frozen = sample;
      frozen.header.stamp = sample.header.stamp;
      player.publishJoint(t >= 2.6 && t < 2.6 + seconds ? frozen : sample);
    };
    const std::size_t before = player.images.size();
    player.play(from, from + 10.4);
    ASSERT_TRUE(waitForImages(before + 4)) << seconds;
    from += 100.0;
  }
  expectSound();
  EXPECT_NEAR(drops("tilt gap") + drops("tilt standing"), 40.0 * 5.8, 10.0);
  EXPECT_EQ(player.diagnosed("Joint jumps"), 2.0);  // after four seconds the motor is where it was
}

TEST_F(SweepFaults, aJointWhoseStampsStandCostsThoseLines) {
  sensor_msgs::JointState frozen;
  player.send_joint = [&](const auto& sample) {
    const double t = sample.header.stamp.toSec() - kStart;
    if (t < 2.6) frozen = sample;
    player.publishJoint(t >= 2.6 && t < 8.6 ? frozen : sample);
  };
  start();
  player.play(kStart, kStart + 8.5);
  // The sweep that was open comes out, though scans go on; and diagnostics say what is amiss.
  ASSERT_TRUE(waitForImages(2));
  EXPECT_NEAR(player.images[1]->height, 24, 2);
  ASSERT_TRUE(told("lines wait for samples of joint 'tilt_joint'"));
  player.play(kStart + 8.5, kStart + 13.0);
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_NEAR(player.linesDropped(), 240.0, 5.0);
  EXPECT_NEAR(drops("queue full"), 40.0, 5.0);
  EXPECT_GT(player.diagnosed("Joint samples rejected: not newer"), 500.0);
}

TEST_F(SweepFaults, anAngleThatWrapsAtPiDoesNotEndASweep) {
  player.tilt = [](double t) { return M_PI - 0.7 * std::cos(2.0 * M_PI * t / 4.0); };
  start();
  player.play(kStart, kStart + 6.4);
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  for (const auto& image : player.images) {
    EXPECT_NEAR(image->height, 80, 3);
    EXPECT_NEAR(image->tilts.back() - image->tilts.front(), 1.4, 0.02);
  }
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, encoderNoiseMakesNoSweepsAtTurningPoints) {
  std::mt19937 random(5);
  player.send_joint = [&](auto sample) {
    sample.position[1] += std::uniform_real_distribution<double>(-0.004, 0.004)(random);
    player.publishJoint(sample);
  };
  // Stands for half a second at each turning point, where noise might be taken for motion.
  player.tilt = [](double t) { return std::min(0.7, std::max(-0.7, -0.95 * std::cos(2.0 * M_PI * t / 4.0))); };
  start();
  player.play(kStart, kStart + 10.6);
  ASSERT_TRUE(waitForImages(5));
  expectAccountsClose();
  EXPECT_EQ(player.images.size(), 5U);
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_NEAR(player.images[i]->height, 80, 40);  // the halt is in this sweep or the next
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.03);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, aChangeOfBeamsOrAnglesInASweepBeginsAnother) {
  start();
  player.play(kStart, kStart + 2.6);
  player.beams = 61;
  player.play(kStart + 2.6, kStart + 3.2);
  player.send_scan = [&](auto scan) {  // the same number of beams, elsewhere
    scan.ranges.erase(scan.ranges.begin(), scan.ranges.begin() + 20);
    scan.intensities.erase(scan.intensities.begin(), scan.intensities.begin() + 20);
    scan.angle_min += 20.0F * scan.angle_increment;
    scan.header.stamp += ros::Duration(20.0 * scan.time_increment);
    player.publishScan(scan);
  };
  player.beams = 81;
  player.play(kStart + 3.2, kStart + 6.4);
  ASSERT_TRUE(waitForImages(5));
  expectSound();
  EXPECT_EQ(player.diagnosed("Layout changes"), 2.0);
  EXPECT_EQ(player.images[1]->width, 121U);
  EXPECT_NEAR(player.images[1]->height, 24, 2);
  EXPECT_EQ(player.images[2]->width, 61U);
  EXPECT_NEAR(player.images[2]->height, 24, 2);
  EXPECT_EQ(player.images[3]->width, 61U);
  EXPECT_NEAR(player.images[3]->bearing_min, -1.0, 1e-5);
  EXPECT_NEAR(player.images[3]->height, 32, 2);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, aSensorUnpluggedIsToldAndPluggedInAgainWorks) {
  start();
  player.play(kStart, kStart + 2.6);
  ASSERT_TRUE(told("no scans"));
  EXPECT_EQ(player.diagnostics.level, diagnostic_msgs::DiagnosticStatus::ERROR);
  ASSERT_TRUE(waitForImages(2));  // what had been seen of the open sweep
  EXPECT_NEAR(player.images[1]->height, 24, 2);
  player.play(kStart + 13.3, kStart + 18.4);  // not at a turning point
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_EQ(player.diagnostics.message.find("no scans"), std::string::npos) << player.diagnostics.message;
  EXPECT_LE(player.linesDropped(), 2.0);
}

TEST_F(SweepFaults, badRangesBecomeNoPoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<float> bad = {nan, inf, -inf, -1.0F, 0.0F, 0.019F, 30.1F, 1e30F, -1e30F, 1e-40F};
  player.send_scan = [&](auto scan) {
    for (std::size_t i = 0; i < bad.size(); ++i) scan.ranges[12 * i] = bad[i];
    scan.intensities[3] = nan;
    player.publishScan(scan);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  for (const auto& cloud : player.clouds) {
    std::size_t valid = 0;
    for (sensor_msgs::PointCloud2ConstIterator<float> p(*cloud, "x"); p != p.end(); ++p) valid += !std::isnan(p[0]);
    EXPECT_EQ(valid, cloud->height * (121U - bad.size()));
  }
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, badFieldsAreRefusedOneByOne) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<std::function<void(sensor_msgs::LaserScan&)>> spoilers = {
      [](auto& s) { s.ranges.clear(); },
      [](auto& s) { s.ranges.resize(60); },
      [](auto& s) {
        s.ranges.resize(1000000);
        s.intensities.clear();
        s.angle_increment = (s.angle_max - s.angle_min) / 999999.0F;
      },
      [](auto& s) { s.intensities.resize(7); },
      [nan](auto& s) { s.angle_increment = nan; },
      [inf](auto& s) { s.angle_increment = inf; },
      [](auto& s) { s.angle_increment = 0.0F; },
      [](auto& s) { s.angle_increment *= 100.0F; },
      [](auto& s) { s.angle_increment *= -1.0F; },
      [](auto& s) { std::swap(s.angle_min, s.angle_max); },
      [nan](auto& s) { s.angle_min = nan; },
      [inf](auto& s) { s.angle_min = -inf; },
      [inf](auto& s) { s.angle_max = inf; },
      [nan](auto& s) { s.time_increment = nan; },
      [inf](auto& s) { s.time_increment = inf; },
      [](auto& s) { s.time_increment = -1e-4F; },
      [](auto& s) { s.time_increment = 1e3F; },
      [nan](auto& s) { s.range_min = nan; },
      [](auto& s) { s.range_min = -1.0F; },
      [nan](auto& s) { s.range_max = nan; },
      [](auto& s) { s.range_max = 0.0F; },
      [](auto& s) { std::swap(s.range_min, s.range_max); },
      [](auto& s) { s.header.stamp = ros::Time(); },
      [](auto& s) { s.header.frame_id = "elsewhere"; },
      [](auto& s) { s.header.frame_id.assign(1000000, 'x'); },
      [](auto& s) { s.header.frame_id.clear(); },
  };
  std::size_t n = 0;
  player.send_scan = [&](const auto& scan) {
    player.publishScan(scan);
    sensor_msgs::LaserScan bad = scan;
    bad.header.stamp += ros::Duration(0.003);
    spoilers[n++ % spoilers.size()](bad);
    player.publishScan(bad);
  };
  start();
  player.play(kStart, kStart + 4.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_EQ(drops("bad scan"), player.scans_sent / 2);
  EXPECT_EQ(player.linesDropped(), player.scans_sent / 2);
}

TEST_F(SweepFaults, aStalledMotorIsTold) {
  set("driver/sweep_timeout", 3.0);
  std::mt19937 random(5);
  double stalled_at = std::numeric_limits<double>::infinity();
  player.tilt = [&](double t) { return -0.7 * std::cos(2.0 * M_PI * std::min(t, stalled_at) / 4.0); };
  player.send_joint = [&](auto sample) {  // a motor that hums is no motor that nods
    const bool stalled = sample.header.stamp.toSec() > stalled_at;
    if (stalled) sample.position[1] += std::uniform_real_distribution<double>(-0.002, 0.002)(random);
    player.publishJoint(sample);
  };
  stalled_at = kStart + 2.8;
  start();
  player.play(kStart, kStart + 8.0);
  ASSERT_TRUE(told("tilt stands still"));
  ASSERT_TRUE(waitForImages(2));  // the sweep that it broke off
  EXPECT_NEAR(player.images[1]->height, 32, 2);
  ASSERT_TRUE(told("no sweep for"));
  expectSound(0.01);
  EXPECT_NEAR(drops("tilt standing"), 5.2 * 40.0, 3.0);
}

TEST_F(SweepFaults, aSecondPublisherOfTheJointIsToldAndMovesNoRow) {
  start();
  player.play(kStart, kStart + 0.4);
  const Stray stray(ns_ + "/joint_states", "sensor_msgs/JointState",
                    "{header: {stamp: now}, name: [tilt_joint], position: [0.0]}");
  ASSERT_TRUE(stray.runs());
  double t = kStart + 0.4;
  const std::string words = "joint 'tilt_joint' is published by /rostopic_";
  for (; t < kStart + 60.0 && player.diagnostics.message.find(words) == std::string::npos; t += 0.4) player.play(t, t + 0.4);
  ASSERT_NE(player.diagnostics.message.find(words), std::string::npos) << player.diagnostics.message;
  const std::size_t before = player.images.size();
  player.play(t, t + 6.4);
  ASSERT_TRUE(waitForImages(before + 3));
  expectSound();
  EXPECT_GT(player.diagnosed("Joint messages rejected: incomplete"), 10.0);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(SweepFaults, aSecondLaserOnTheTopicIsToldAndMakesNoRows) {
  start();
  player.play(kStart, kStart + 0.4);
  std::string ranges = "1.0";
  for (int i = 1; i < player.beams; ++i) ranges += ", 1.0";
  const std::string scan =
      "{header: {stamp: now, frame_id: " + ns_.substr(1) +
      "_laser}, angle_min: -1.5, angle_max: 1.5, angle_increment: " + "0.025, range_min: 0.02, range_max: 30.0, ranges: [" +
      ranges + "]}";
  const Stray stray(ns_ + "/scan", "sensor_msgs/LaserScan", scan.c_str());
  ASSERT_TRUE(stray.runs());
  double t = kStart + 0.4;
  const std::string words = "bad scan: published by /rostopic_";
  for (; t < kStart + 60.0 && player.diagnostics.message.find(words) == std::string::npos; t += 0.4) player.play(t, t + 0.4);
  ASSERT_NE(player.diagnostics.message.find(words), std::string::npos) << player.diagnostics.message;
  const std::size_t before = player.images.size();
  player.play(t, t + 6.4);
  ASSERT_TRUE(waitForImages(before + 3));
  for (const auto& cloud : player.clouds) EXPECT_LT(worstPoint(*cloud), 0.002);
  ASSERT_TRUE(settle());
  EXPECT_GT(drops("bad scan"), 10);
  EXPECT_EQ(player.linesDropped(), drops("bad scan"));
}

/// The joint of the other tests is replaced by tf.
class TfFaults : public FaultRig {
 protected:
  TfFaults() {
    set("driver/joint_name", std::string());
    player.with_joint = false;
    player.with_tf = true;
  }
};

TEST_F(TfFaults, aTransformThatNeverComesIsToldAndItsLinesAreGivenUp) {
  set("driver/max_wait", 2.0);
  player.silent = [](double t) { return t < kStart + 6.0; };
  start();
  player.play(kStart, kStart + 5.0);
  const std::string name = ns_.substr(1);
  ASSERT_TRUE(told("lines wait for tf " + name + "_base <- " + name + "_laser"));
  ASSERT_TRUE(settle());
  EXPECT_NEAR(drops("no transform"), 3.0 * 40.0, 5.0);
  EXPECT_NEAR(player.diagnosed("Lines pending"), 2.0 * 40.0, 5.0);
  player.play(kStart + 5.0, kStart + 10.4);
  ASSERT_TRUE(waitForImages(2));
  expectSound();
  EXPECT_NEAR(drops("no transform"), 6.0 * 40.0, 5.0);
  EXPECT_EQ(player.linesDropped(), drops("no transform"));
}

TEST_F(TfFaults, missingTransformsCostThoseLines) {
  player.silent = [](double t) { return t > kStart + 2.6 && t < kStart + 3.4; };
  start();
  player.play(kStart, kStart + 8.4);
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_NEAR(drops("tilt gap"), 32.0, 3.0);
  EXPECT_EQ(player.linesDropped(), drops("tilt gap"));
}

TEST_F(TfFaults, transformsMissingWhereTheMotorTurnsCostThoseLines) {
  // Shorter than max_joint_gap, but the motor comes to a stop and back in them.
  player.silent = [](double t) { return std::abs(std::remainder(t - kStart, 2.0)) < 0.095; };
  start();
  player.play(kStart - 1.0, kStart + 8.4);
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_NEAR(drops("tilt gap"), 5 * 8.0, 6.0);
  EXPECT_LE(player.linesDropped() - drops("tilt gap"), 3.0);
}

TEST_F(TfFaults, wrongTransformsNowAndThenMoveNoRow) {
  start();
  player.with_tf = false;  // published below
  const std::string base = ns_.substr(1) + "_base", laser = ns_.substr(1) + "_laser";
  for (int tick = 0; tick < 1700; ++tick) {
    const double t = kStart + tick / 200.0;
    const bool wrong = tick > 400 && tick % 100 == 0;  // as of a joint whose encoder was misread
    if (tick % 2 == 0) player.publishTransform(t, base, laser, player.laserAt(wrong ? t + 1.0 : t));
    if (tick % 5 == 0) player.send_scan(player.scan(t));
    ros::spinOnce();
    ros::WallDuration(0.001).sleep();
  }
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_GT(player.diagnosed("Tf samples rejected: implausible"), 8.0);
  EXPECT_EQ(player.linesDropped(), drops("tilt gap") + drops("no transform"));
  EXPECT_LE(player.linesDropped(), 2.0 * 13.0 + 3.0);
}

TEST_F(TfFaults, lateTransformsLoseNothing) {
  start();
  player.with_tf = false;  // published below, late
  const std::string name = ns_.substr(1);
  for (int tick = 0; tick < 2500; ++tick) {
    const double t = kStart + tick / 200.0;
    const double late = 0.1 * std::min(5, tick / 400);  // 0 to 500 ms; when it grows, nothing comes for a while
    if (tick % 2 == 0) player.publishTransform(t - late, name + "_base", name + "_laser", player.laserAt(t - late));
    if (tick % 5 == 0) player.send_scan(player.scan(t));
    ros::spinOnce();
    ros::WallDuration(0.001).sleep();
  }
  ASSERT_TRUE(waitForImages(6));
  expectSound();
  EXPECT_NEAR(player.images[4]->height, 80, 3);
  EXPECT_EQ(player.linesDropped(), 0.0);
}

TEST_F(TfFaults, badTransformsAmongGoodOnesMoveNoRow) {
  start();
  player.with_tf = false;  // published below
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::string base = ns_.substr(1) + "_base", laser = ns_.substr(1) + "_laser";
  for (int tick = 0; tick < 1700; ++tick) {
    const double t = kStart + tick / 200.0;
    const Eigen::Isometry3d good = player.laserAt(t);
    if (tick % 2 == 0) player.publishTransform(t, base, laser, good);
    Eigen::Isometry3d bad = good;
    if (tick % 6 == 0) bad.translation().x() = nan;
    // tf2 takes this one, and interpolates with it: the lines about it have no pose.
    if (tick >= 600 && tick < 660 && tick % 6 == 1) bad.translation().z() = -inf;
    if (tick % 6 == 2) bad.linear().fill(nan);
    if (tick % 6 == 3) bad.linear().setZero();
    if (tick % 6 == 4) player.publishTransform(t, laser, laser, good);
    if (tick % 6 == 5) player.publishTransform(t, "", laser, good);
    if (!bad.isApprox(good)) player.publishTransform(t + 0.001, base, laser, bad);
    if (tick % 5 == 0) player.send_scan(player.scan(t));
    ros::spinOnce();
    ros::WallDuration(0.001).sleep();
  }
  ASSERT_TRUE(waitForImages(4));
  expectSound();
  EXPECT_NEAR(drops("no transform"), 12.0, 5.0);
  EXPECT_LE(player.linesDropped() - drops("no transform"), 3.0);
}

TEST_F(TfFaults, aClockSetBackMixesNoTransforms) {
  double shift = 0.0;
  player.send_scan = [&](auto scan) {
    scan.header.stamp += ros::Duration(shift);
    player.publishScan(scan);
  };
  start();
  player.with_tf = false;  // published below, with the clock that is set
  const std::string name = ns_.substr(1);
  for (int tick = 0; tick < 1800; ++tick) {
    const double t = kStart + tick / 200.0;
    if (tick == 700) shift = -3.0;  // within what tf2 remembers
    if (tick % 2 == 0) player.publishTransform(t + shift, name + "_base", name + "_laser", player.laserAt(t));
    if (tick % 5 == 0) player.send_scan(player.scan(t));
    ros::spinOnce();
    ros::WallDuration(0.001).sleep();
  }
  ASSERT_TRUE(waitForImages(3));
  expectSound();
  EXPECT_EQ(player.diagnosed("Clock resets"), 1.0);
}

TEST_F(TfFaults, aFixedFrameThatNobodyPublishesIsTold) {
  set("driver/joint_name", std::string("tilt_joint"));
  set("driver/fixed_frame", std::string("odom"));
  set("driver/max_wait", 1.0);
  player.with_joint = true;
  player.with_tf = false;
  start();
  player.play(kStart, kStart + 4.0);
  ASSERT_TRUE(told("lines wait for tf odom <- " + ns_.substr(1) + "_base"));
  expectSound();
  EXPECT_NEAR(drops("no transform"), 3.0 * 40.0, 5.0);
  EXPECT_TRUE(player.images.empty());
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_sweep_faults"); }
