// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/tf_pose_sources.h"

#include "patch_plane_clustering/ros/laser_poses.h"
#include "patch_plane_clustering/ros/mount_finder.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <thread>

namespace ppc {
namespace {

Eigen::Isometry3d turn(double angle, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitY()) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, axis));
}

struct Tree {
  tf2::BufferCore buffer{ros::Duration(60.0)};
  void set(double stamp, const std::string& parent, const std::string& child, const Eigen::Isometry3d& pose,
           bool is_static = false) {
    geometry_msgs::TransformStamped t;
    t.header.stamp = toTime(stamp);
    t.header.frame_id = parent;
    t.child_frame_id = child;
    const Eigen::Quaterniond q(pose.linear());
    t.transform.translation.x = pose.translation().x();
    t.transform.translation.y = pose.translation().y();
    t.transform.translation.z = pose.translation().z();
    t.transform.rotation.x = q.x();
    t.transform.rotation.y = q.y();
    t.transform.rotation.z = q.z();
    t.transform.rotation.w = q.w();
    buffer.setTransform(t, "test", is_static);
  }
};

Eigen::Isometry3d leverArm() { return Eigen::Isometry3d(Eigen::Translation3d(0.01, 0.02, 0.08)) * turn(0.1); }

TEST(TransformTrack, interpolatesAndNeverExtrapolates) {
  Tree tree;
  TransformTrack track(tree.buffer, "base", "laser", 0.5);
  Eigen::Isometry3d pose;
  EXPECT_EQ(track.at(10.0, pose), PoseStatus::kWaitTransform);
  tree.set(10.0, "base", "laser", turn(0.0));
  tree.set(10.2, "base", "laser", turn(0.2));
  ASSERT_EQ(track.at(10.1, pose), PoseStatus::kReady);
  EXPECT_TRUE(pose.isApprox(turn(0.1), 1e-9));
  EXPECT_EQ(track.at(10.3, pose), PoseStatus::kWaitTransform);
  EXPECT_EQ(track.at(15.3, pose), PoseStatus::kNoTransform);  // nobody waits for ever
  EXPECT_EQ(track.at(9.9, pose), PoseStatus::kNoTransform);
}

TEST(TransformTrack, doesNotBridgeAHole) {
  Tree tree;
  TransformTrack track(tree.buffer, "base", "laser", 0.5);
  Eigen::Isometry3d pose;
  tree.set(10.0, "base", "laser", turn(0.0));
  EXPECT_EQ(track.at(10.5, pose), PoseStatus::kWaitTransform);
  tree.set(12.0, "base", "laser", turn(0.2));
  EXPECT_EQ(track.at(10.5, pose), PoseStatus::kTiltGap);
  EXPECT_EQ(track.at(12.0, pose), PoseStatus::kReady);
  tree.set(12.1, "base", "laser", turn(0.3));
  EXPECT_EQ(track.at(12.05, pose), PoseStatus::kReady);
}

TEST(TransformTrack, aStaticTransformHoldsAtAnyTime) {
  Tree tree;
  tree.set(0.0, "base", "laser", leverArm(), true);
  TransformTrack track(tree.buffer, "base", "laser", 0.5);
  Eigen::Isometry3d pose;
  ASSERT_EQ(track.at(123.0, pose), PoseStatus::kReady);
  EXPECT_TRUE(pose.isApprox(leverArm(), 1e-9));
}

TEST(TransformTrack, aHoleIsSeenThoughNobodyAsksWhileItComes) {
  Tree tree;
  TransformTrack track(tree.buffer, "base", "laser", 0.5);
  for (const double t : {10.0, 10.1, 12.0, 12.1, 12.2}) tree.set(t, "base", "laser", turn(0.1 * (t - 10.0)));
  Eigen::Isometry3d pose;
  EXPECT_EQ(track.at(10.05, pose), PoseStatus::kReady);
  EXPECT_EQ(track.at(11.0, pose), PoseStatus::kTiltGap);
  EXPECT_EQ(track.at(12.05, pose), PoseStatus::kReady);
}

TEST(TransformWatch, seesEverySampleOfAChainOnce) {
  Tree tree;
  tree.set(0.0, "base", "pan", leverArm(), true);
  TransformWatch watch(tree.buffer, "base", "laser");
  tree.set(10.0, "pan", "tilt", turn(0.0));
  EXPECT_TRUE(watch.take().empty());  // tilt is not known to carry the laser yet
  tree.set(10.0, "tilt", "laser", leverArm());
  for (int i = 1; i <= 5; ++i) {
    tree.set(10.0 + 0.1 * i, "pan", "tilt", turn(0.1 * i));
    tree.set(10.0 + 0.1 * i, "elsewhere", "camera", turn(0.0));
    tree.set(10.0 + 0.1 * i, "tilt", "laser", leverArm());
  }
  const std::vector<StampedTransform> samples = watch.take();
  ASSERT_EQ(samples.size(), 6U);
  for (int i = 0; i <= 5; ++i) {
    EXPECT_NEAR(samples[i].stamp, 10.0 + 0.1 * i, 1e-6);
    EXPECT_TRUE(samples[i].transform.isApprox(leverArm() * turn(0.1 * i) * leverArm(), 1e-9)) << i;
  }
  EXPECT_TRUE(watch.take().empty());
  tree.buffer.clear();
  watch.reset();
  tree.set(10.5, "base", "laser", turn(0.0));  // the stamp of the last one, of another run
  EXPECT_EQ(watch.take().size(), 1U);
}

TEST(TransformWatch, samplesThatComeWhileOthersAreTakenAreNeitherLostNorDoubled) {
  Tree tree;
  TransformWatch watch(tree.buffer, "base", "laser");
  std::vector<StampedTransform> samples;
  const auto take = [&] {
    for (const StampedTransform& sample : watch.take()) samples.push_back(sample);
  };
  std::thread filler([&] {
    for (int i = 0; i < 2000; ++i) tree.set(10.0 + 0.01 * i, "base", "laser", turn(0.0));
  });
  while (samples.size() < 1000U) take();
  filler.join();
  take();
  ASSERT_EQ(samples.size(), 2000U);
  for (int i = 0; i < 2000; ++i) ASSERT_NEAR(samples[i].stamp, 10.0 + 0.01 * i, 1e-6);
}

TEST(TransformWatch, mayEndWhileSamplesCome) {
  Tree tree;
  std::atomic<bool> ended{false};
  std::thread filler([&] {
    for (int i = 0; !ended; ++i) tree.set(10.0 + 0.001 * i, "base", "laser", turn(0.0));
  });
  for (int seen = 0; seen < 200;) {  // else the test takes until its time limit
    TransformWatch watch(tree.buffer, "base", "laser");
    seen += watch.take().empty() ? 0 : 1;
  }
  ended = true;
  filler.join();
}

TfPoseSource tfSource(Tree& tree) {
  return TfPoseSource(Eigen::Vector3d::UnitY(), TransformTrack(tree.buffer, "base", "laser", 0.5));
}

TEST(TfPoseSource, theTiltIsTheRotationAboutTheAxis) {
  Tree tree;
  TfPoseSource source = tfSource(tree);
  for (int i = 0; i <= 100; ++i) tree.set(10.0 + 0.1 * i, "base", "laser", turn(0.1 * i - 1.0) * leverArm());
  LaserPose pose;
  for (int i = 0; i <= 99; ++i) {  // beyond half a turn: unwrapped
    ASSERT_EQ(source.at(10.05 + 0.1 * i, pose), PoseStatus::kReady);
    EXPECT_NEAR(pose.tilt, 0.1 * i - 0.95 + 0.1, 1e-6);  // the mount's own 0.1 rad about the axis counts
    EXPECT_TRUE(pose.pose.isApprox(turn(0.1 * i - 0.95) * leverArm(), 1e-3));
  }
}

TEST(TfPoseSource, anUpsideDownLaserHasATiltToo) {
  Tree tree;
  TfPoseSource source = tfSource(tree);
  const Eigen::Isometry3d upside_down = turn(M_PI, Eigen::Vector3d::UnitX());
  for (int i = 0; i <= 10; ++i) tree.set(10.0 + 0.1 * i, "base", "laser", turn(0.1 * i + 0.2) * upside_down);
  LaserPose pose;
  for (int i = 0; i <= 10; ++i) {
    ASSERT_EQ(source.at(10.0 + 0.1 * i, pose), PoseStatus::kReady);
    EXPECT_NEAR(pose.tilt, 0.1 * i, 1e-6);
  }
}

TEST(TfPoseSource, aStaticLaserHasOneTiltAtAnyTime) {
  Tree tree;
  tree.set(0.0, "base", "laser", leverArm(), true);
  TfPoseSource source = tfSource(tree);
  LaserPose pose;
  ASSERT_EQ(source.at(123.0, pose), PoseStatus::kReady);
  EXPECT_NEAR(pose.tilt, 0.1, 1e-9);
}

/// Times of 20 s of a motor, sampled at 100 Hz without those that `misses` tells, at which a source has a pose that is
/// wrong, and at which it has none.
struct Answers {
  int asked = 0, wrong = 0, none = 0;
};
Answers ask(
    const std::function<double(double)>& motion, const std::function<bool(int)>& misses,
    const std::function<double(int, double)>& spoil = [](int, double tilt) { return tilt; }) {
  Tree tree;
  TfPoseSource source = tfSource(tree);
  for (int i = 0; i <= 2000; ++i) {
    const double tilt = spoil(i, motion(0.01 * i));
    if (!misses(i)) tree.set(10.0 + 0.01 * i, "base", "laser", turn(tilt) * leverArm());
  }
  Answers answers;
  for (double t = 1.0; t < 18.0; t += 0.0037) {
    LaserPose pose;
    ++answers.asked;
    if (source.at(10.0 + t, pose) != PoseStatus::kReady) {
      ++answers.none;
    } else if (std::abs(std::remainder(pose.tilt - motion(t) - 0.1, 2.0 * M_PI)) > 0.0006 ||
               !pose.pose.isApprox(turn(motion(t)) * leverArm(), 0.0006)) {
      ++answers.wrong;
    }
  }
  return answers;
}

double nod(double t) { return -0.7 * std::cos(2.0 * M_PI * t / 4.0); }

TEST(TfPoseSource, noHoleIsBridgedWhereTheMotionMayLeaveTheLine) {
  for (const int length : {3, 10, 30}) {
    const auto misses = [&](int i) { return i % (2 * length + 33) < length; };
    const Answers nodding = ask(nod, misses);
    EXPECT_EQ(nodding.wrong, 0) << length;
    const Answers steady = ask([](double t) { return 0.3 * t; }, misses);
    EXPECT_EQ(steady.wrong, 0) << length;
    EXPECT_EQ(steady.none, 0) << length;
  }
  const Answers whole = ask(nod, [](int) { return false; });
  EXPECT_EQ(whole.wrong + whole.none, 0);
}

TEST(TfPoseSource, wrongSamplesMoveNoRow) {
  const auto misses = [](int) { return false; };
  const auto spoilt = [](int i, double tilt) { return i % 50 == 7 ? tilt + 1.0 : tilt; };
  const Answers answers = ask(nod, misses, spoilt);
  EXPECT_EQ(answers.wrong, 0);
  EXPECT_LT(answers.none, 0.05 * answers.asked);  // both intervals beside each: 4 % of the time
}

TEST(TfPoseSource, aFrozenJointLeavesAGap) {
  const auto misses = [](int) { return false; };
  const auto frozen = [](int i, double tilt) { return i % 400 >= 80 && i % 400 < 110 ? nod(0.79 + 4.0 * (i / 400)) : tilt; };
  const Answers answers = ask(nod, misses, frozen);
  EXPECT_EQ(answers.wrong, 0);
  EXPECT_LT(answers.none, 0.09 * answers.asked);  // frozen for 7.5 % of the time
}

TEST(TfPoseSource, aJumpIsNoMotion) {
  const auto misses = [](int) { return false; };
  const auto jumping = [](double t) { return 0.1 * t + (t < 9.005 ? 0.0 : 1.0); };
  const Answers answers = ask(jumping, misses);
  EXPECT_EQ(answers.wrong, 0);
  EXPECT_LE(answers.none, 4);
  Tree tree;
  TfPoseSource source = tfSource(tree);
  for (int i = 0; i <= 20; ++i) tree.set(10.0 + 0.01 * i, "base", "laser", turn(i < 10 ? 0.0 : 1.0));
  LaserPose pose;
  EXPECT_EQ(source.at(10.15, pose), PoseStatus::kReady);
  EXPECT_EQ(source.jumps(), 1U);
  EXPECT_TRUE(source.jumpedBetween(10.05, 10.15));
  EXPECT_FALSE(source.jumpedBetween(10.11, 10.15));
}

TEST(MovingBaseSource, posesComeOutInTheFixedFrame) {
  Tree tree;
  TiltPoseSource joint(Eigen::Vector3d::UnitY(), {});
  joint.setMount(leverArm());
  for (int i = 0; i <= 10; ++i) {
    joint.track().add(10.0 + 0.1 * i, 0.1 * i);
    if (i <= 5) tree.set(10.0 + 0.1 * i, "odom", "base", Eigen::Isometry3d(Eigen::Translation3d(0.2 * i, 0.0, 0.0)));
  }
  MovingBaseSource source(joint, TransformTrack(tree.buffer, "odom", "base", 0.5));
  LaserPose pose;
  ASSERT_EQ(source.at(10.25, pose), PoseStatus::kReady);
  EXPECT_NEAR(pose.tilt, 0.25, 1e-9);
  EXPECT_TRUE(pose.base.translation().isApprox(Eigen::Vector3d(0.5, 0.0, 0.0), 1e-6));
  EXPECT_TRUE(pose.pose.isApprox(pose.base * turn(0.25) * leverArm(), 1e-9));
  EXPECT_EQ(source.at(10.8, pose), PoseStatus::kWaitTransform);
  EXPECT_EQ(source.at(9.0, pose), PoseStatus::kNoTilt);
}

TEST(MountFinder, removesTheTiltAndAsksForASecondOpinion) {
  Tree tree;
  TiltPoseSource joint(Eigen::Vector3d::UnitY(), {});
  MountFinder finder(TransformTrack(tree.buffer, "base", "laser", 0.5));
  EXPECT_FALSE(finder.look(joint));
  bool confirmed = false;
  int looks = 0;
  for (int i = 0; i <= 10 && !confirmed; ++i, ++looks) {
    const double tilt = 0.3 + 0.004 * i;
    joint.track().add(10.0 + 0.1 * i, tilt);
    tree.set(10.0 + 0.1 * i, "base", "laser", turn(tilt) * leverArm());
    confirmed = finder.look(joint);
  }
  EXPECT_TRUE(confirmed);
  EXPECT_EQ(looks, 4);  // until the tilt has moved by more than 0.01 rad
  ASSERT_TRUE(finder.mount());
  EXPECT_TRUE(finder.mount()->isApprox(leverArm(), 1e-6));
}

TEST(MountFinder, aTreeThatIgnoresTheJointIsContradicted) {
  Tree tree;
  tree.set(0.0, "base", "laser", leverArm(), true);
  TiltPoseSource joint(Eigen::Vector3d::UnitY(), {});
  MountFinder finder(TransformTrack(tree.buffer, "base", "laser", 0.5));
  joint.track().add(10.0, 0.3);
  EXPECT_FALSE(finder.look(joint));
  EXPECT_TRUE(finder.mount());
  joint.track().add(10.1, 0.32);
  EXPECT_TRUE(finder.look(joint));
  EXPECT_TRUE(finder.contradicted());
  EXPECT_FALSE(finder.mount());
}

TEST(LaserPoses, saysWhereTheMountComesFrom) {
  Tree tree;
  DriverOptions options;
  options.joint_name = "tilt_joint";
  EXPECT_TRUE(LaserPoses::needsTf(options));
  LaserPoses poses(options, &tree.buffer);
  LaserPose pose;
  EXPECT_EQ(poses.at(10.0, pose), PoseStatus::kWaitTransform);
  poses.setLaserFrame("laser");
  poses.joint()->track().add(10.0, 0.0);
  EXPECT_EQ(poses.at(10.0, pose), PoseStatus::kWaitTransform);
  EXPECT_EQ(poses.settleMount(false), "");
  EXPECT_FALSE(poses.mountKnown());
  const std::string sentence = poses.settleMount(true);
  EXPECT_NE(sentence.find("default, for tf does not know tilt_base <- laser"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("lever_arm [0.0000, 0.0000, 0.0000]"), std::string::npos) << sentence;
  EXPECT_EQ(poses.at(10.0, pose), PoseStatus::kReady);
  options.mount = leverArm();
  EXPECT_FALSE(LaserPoses::needsTf(options));
  EXPECT_EQ(describeMount(leverArm()), "lever_arm [0.0100, 0.0200, 0.0800] m, mount_rpy [0.0000, 0.1000, 0.0000] rad");
}

}  // namespace
}  // namespace ppc
