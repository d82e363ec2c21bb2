// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/tilt_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ppc {
namespace {

using Status = TiltTrack::Status;

TEST(TiltTrack, interpolatesLinearlyBetweenBracketingSamples) {
  TiltTrack track;
  track.add(10.0, 0.1);
  track.add(10.2, 0.5);
  double angle = 0.0;
  ASSERT_EQ(track.lookup(10.05, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.2, 1e-12);
  ASSERT_EQ(track.lookup(10.0, angle), Status::kReady);
  EXPECT_EQ(angle, 0.1);
  ASSERT_EQ(track.lookup(10.2, angle), Status::kReady);
  EXPECT_EQ(angle, 0.5);
}

TEST(TiltTrack, neverExtrapolates) {
  TiltTrack track;
  double angle = 42.0;
  EXPECT_EQ(track.lookup(10.0, angle), Status::kTooNew);
  track.add(10.0, 0.1);
  track.add(10.1, 0.2);
  EXPECT_EQ(track.lookup(10.1000001, angle), Status::kTooNew);
  EXPECT_EQ(track.lookup(9.9999999, angle), Status::kTooOld);
  EXPECT_NE(track.lookup(std::numeric_limits<double>::quiet_NaN(), angle), Status::kReady);
  EXPECT_EQ(angle, 42.0);
}

TEST(TiltTrack, doesNotBridgeAGap) {
  TiltTrackOptions options;
  options.max_gap = 0.3;
  TiltTrack track(options);
  track.add(1.0, 0.0);
  track.add(1.25, 0.1);
  track.add(1.7, 0.2);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(1.24, angle), Status::kReady);
  EXPECT_EQ(track.lookup(1.5, angle), Status::kGap);
  EXPECT_EQ(track.lookup(1.7, angle), Status::kReady);
}

TEST(TiltTrack, unwrapsAcrossPi) {
  TiltTrack track;
  track.add(1.0, 3.1);
  track.add(1.1, -3.1);
  double angle = 0.0;
  ASSERT_EQ(track.lookup(1.05, angle), Status::kReady);
  EXPECT_NEAR(angle, M_PI, 1e-12);
  track.add(1.2, 3.1);
  EXPECT_NEAR(track.newestAngle(), 3.1, 1e-12);
}

TEST(TiltTrack, countsTurnsOfASpinningJoint) {
  TiltTrack track;
  for (int i = 0; i <= 100; ++i) track.add(1.0 + 0.1 * i, std::remainder(0.2 * i, 2.0 * M_PI));
  EXPECT_NEAR(track.newestAngle(), 20.0, 1e-9);
}

TEST(TiltTrack, anAngleIsTheSampleItselfWhateverCameBefore) {
  TiltTrack track;
  for (int i = 0; i < 1000; ++i) track.add(1.0 + 0.01 * i, 0.7 * std::sin(0.1 * i));
  double angle = 0.0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(track.lookup(1.0 + 0.01 * i, angle), Status::kReady);
    ASSERT_EQ(angle, 0.7 * std::sin(0.1 * i));  // to the bit
  }
}

TEST(TiltTrack, knowsWhenTheAngleJumped) {
  TiltTrack track;
  for (int i = 0; i < 10; ++i) track.add(1.0 + 0.01 * i, 0.01 * i);
  EXPECT_FALSE(track.jumpedBetween(0.0, 2.0));
  for (int i = 10; i < 20; ++i) track.add(1.0 + 0.01 * i, 1.0 + 0.01 * i);
  EXPECT_TRUE(track.jumpedBetween(1.085, 1.105));
  EXPECT_TRUE(track.jumpedBetween(0.0, 2.0));
  EXPECT_FALSE(track.jumpedBetween(1.0, 1.095));
  EXPECT_FALSE(track.jumpedBetween(1.105, 2.0));
}

TEST(TiltTrack, rejectsBadSamplesByCause) {
  TiltTrack track;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  track.add(10.0, 0.1);
  track.add(nan, 0.1);
  track.add(10.1, nan);
  track.add(10.1, -inf);
  track.add(10.0, 0.2);
  track.add(9.9, 0.3);
  EXPECT_EQ(track.counts().accepted, 1U);
  EXPECT_EQ(track.counts().not_finite, 3U);
  EXPECT_EQ(track.counts().not_newer, 2U);
  EXPECT_EQ(track.newestAngle(), 0.1);
}

TEST(TiltTrack, ignoresASingleGlitch) {
  TiltTrack track;
  for (int i = 0; i < 20; ++i) track.add(1.0 + 0.02 * i, i == 10 ? 2.5 : 0.01 * i);
  EXPECT_EQ(track.counts().implausible, 1U);
  double angle = 0.0;
  ASSERT_EQ(track.lookup(1.2, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.1, 1e-12);
}

TEST(TiltTrack, acceptsAConfirmedJumpWithoutInterpolatingAcrossIt) {
  TiltTrack track;
  track.add(1.0, 0.0);
  for (int i = 1; i <= 3; ++i) track.add(1.0 + 0.02 * i, 2.0 + 0.001 * i);
  EXPECT_EQ(track.counts().accepted, 4U);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(1.01, angle), Status::kGap);
  ASSERT_EQ(track.lookup(1.03, angle), Status::kReady);
  EXPECT_NEAR(angle, 2.0015, 1e-12);
}

TEST(TiltTrack, oneSampleFromTheFutureChangesNothing) {
  TiltTrack track;
  track.add(1.0, 0.0);
  track.add(5000.0, 0.01);
  track.add(1.1, 0.1);
  EXPECT_EQ(track.newestStamp(), 1.1);
  EXPECT_EQ(track.counts().implausible, 1U);
}

TEST(TiltTrack, startsAgainWhenTheClockJumpsBack) {
  TiltTrack track;
  for (int i = 0; i < 10; ++i) track.add(100.0 + 0.1 * i, 0.1 * i);
  track.add(50.0, 0.0);
  track.add(50.1, 0.1);
  EXPECT_EQ(track.counts().clock_resets, 0U);
  track.add(50.2, 0.2);
  EXPECT_EQ(track.counts().clock_resets, 1U);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(100.5, angle), Status::kTooNew);
  ASSERT_EQ(track.lookup(50.05, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.05, 1e-12);
}

TEST(TiltTrack, aClockSetBackALittleStartsAgainToo) {
  TiltTrack track;
  for (int i = 0; i < 50; ++i) track.add(100.0 + 0.01 * i, 0.001 * i);
  for (int i = 0; i < 3; ++i) track.add(100.2 + 0.01 * i, 0.5 + 0.001 * i);
  EXPECT_EQ(track.counts().clock_resets, 1U);
  EXPECT_EQ(track.counts().not_newer, 0U);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(100.3, angle), Status::kTooNew);
  ASSERT_EQ(track.lookup(100.215, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.5015, 1e-12);
}

TEST(TiltTrack, lateSamplesBetweenOthersAreIgnored) {
  TiltTrack track;
  for (int i = 0; i < 50; ++i) {
    track.add(100.0 + 0.01 * i, 0.001 * i);
    track.add(99.8 + 0.01 * i, 0.7);
  }
  EXPECT_EQ(track.counts().clock_resets, 0U);
  EXPECT_EQ(track.counts().not_newer, 50U);
}

/// Samples at 100 Hz of a motor that nods, with the encoder frozen from sample `from` to before `to`.
TiltTrack frozenTrack(int from, int to) {
  TiltTrack track;
  const auto tilt = [](int i) { return -0.7 * std::cos(2.0 * M_PI * i / 400.0); };
  for (int i = 0; i < 200; ++i) track.add(1.0 + 0.01 * i, tilt(i >= from && i < to ? from - 1 : i));
  return track;
}

TEST(TiltTrack, aFrozenEncoderLeavesAGap) {
  for (const int to : {85, 120, 150}) {  // a leap that might be a fast motor's, and one that cannot be
    const TiltTrack track = frozenTrack(80, to);
    EXPECT_EQ(track.counts().jumps, 1U) << to;
    double angle = 0.0;
    ASSERT_EQ(track.lookup(1.785, angle), Status::kReady);
    EXPECT_NEAR(angle, -0.7 * std::cos(2.0 * M_PI * 78.5 / 400.0), 1e-4);
    for (double t = 1.801; t < 1.0 + 0.01 * to - 0.0005; t += 0.0033) EXPECT_EQ(track.lookup(t, angle), Status::kGap) << t;
    EXPECT_EQ(track.lookup(1.8 + 0.01, angle), Status::kGap);
    ASSERT_EQ(track.lookup(1.0 + 0.01 * to + 0.005, angle), Status::kReady) << to;
    EXPECT_NEAR(angle, -0.7 * std::cos(2.0 * M_PI * (to + 0.5) / 400.0), 1e-4);
  }
}

TEST(TiltTrack, aGapIsBridgedOnlyWhereTheMotionIsSteady) {
  TiltTrack track;
  const auto tilt = [](double t) { return -0.7 * std::cos(2.0 * M_PI * t / 4.0); };
  for (int i = 0; i <= 400; ++i) {
    const bool steady = i > 90 && i<120, turning = i> 180 && i < 210;
    if (!steady && !turning) track.add(10.0 + 0.01 * i, tilt(0.01 * i));
  }
  double angle = 0.0;
  ASSERT_EQ(track.lookup(11.05, angle), Status::kReady);  // close to the middle, where the motor is fast
  EXPECT_NEAR(angle, tilt(1.05), 0.005);
  EXPECT_EQ(track.lookup(11.95, angle), Status::kGap);  // around its turning point
  EXPECT_EQ(track.lookup(12.15, angle), Status::kReady);
}

TEST(TiltTrack, aMotorThatStepsOrAnEncoderReadSlowlyIsNotFrozen) {
  TiltTrack steps, slow;
  for (int i = 0; i < 300; ++i) {
    steps.add(1.0 + 0.01 * i, 0.02 * (i / 10));
    slow.add(1.0 + 0.01 * i, 0.005 * (i / 5 * 5));
  }
  double angle = 0.0;
  EXPECT_EQ(steps.counts().jumps + slow.counts().jumps, 0U);
  EXPECT_EQ(steps.lookup(2.035, angle), Status::kReady);
  EXPECT_EQ(slow.lookup(2.035, angle), Status::kReady);
}

TEST(TiltTrack, aMotorThatStopsAndGoesOnIsNotFrozen) {
  TiltTrack track;
  for (int i = 0; i < 300; ++i) track.add(1.0 + 0.01 * i, 0.005 * (i < 100 ? i : i < 200 ? 100 : i - 100));
  EXPECT_EQ(track.counts().jumps, 0U);
  double angle = 0.0;
  ASSERT_EQ(track.lookup(2.505, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.5, 1e-12);
}

TEST(TiltTrack, forgetsTheOldestBeyondItsCapacity) {
  TiltTrackOptions options;
  options.capacity = 10;
  TiltTrack track(options);
  for (int i = 0; i < 1000; ++i) track.add(1.0 + 0.1 * i, 0.01 * i);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(track.newestStamp() - 0.95, angle), Status::kTooOld);
  EXPECT_EQ(track.lookup(track.newestStamp() - 0.85, angle), Status::kReady);
}

}  // namespace
}  // namespace ppc
