// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/tilt_track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace ppc {
namespace {

using Status = TiltTrack::Status;

TEST(TiltTrack, interpolatesLinearlyBetweenBracketingSamples) {
  TiltTrack track;
  track.add(10.0, 0.1);
  track.add(10.2, 0.5);
  for (int i = 2; i <= 4; ++i) track.add(10.0 + 0.2 * i, 0.5);
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
  for (int i = 0; i <= 5; ++i) track.add(0.25 * i, 0.1);
  track.add(1.7, 0.2);
  double angle = 0.0;
  EXPECT_EQ(track.lookup(1.24, angle), Status::kReady);
  EXPECT_EQ(track.lookup(1.5, angle), Status::kGap);
  EXPECT_EQ(track.lookup(1.7, angle), Status::kReady);
}

TEST(TiltTrack, unwrapsAcrossPi) {
  TiltTrack track;
  track.add(1.0, 3.1);
  for (const double t : {1.1, 1.2, 1.3}) track.add(t, -3.1);
  track.add(1.4, 3.1);
  EXPECT_NEAR(track.newestAngle(), 3.1, 1e-12);
  double angle = 0.0;
  ASSERT_EQ(track.lookup(1.05, angle), Status::kReady);
  EXPECT_NEAR(angle, M_PI, 1e-12);
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
  for (int i = 4; i <= 6; ++i) track.add(1.0 + 0.02 * i, 2.0 + 0.001 * i);
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
  for (const double t : {50.3, 50.4}) track.add(t, 0.2);
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
  for (int i = 3; i < 6; ++i) track.add(100.2 + 0.01 * i, 0.5 + 0.001 * i);
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

using Motion = std::function<double(double)>;

double nod(double t) { return -0.7 * std::cos(2.0 * M_PI * t / 4.0); }
double zigzag(double t) { return std::abs(std::remainder(t, 4.0)) * 0.7 - 0.7; }

/// Samples of a motion at `rate` [Hz] over 20 s, without those that `misses` tells, and what lookups between them give.
struct Bridged {
  double worst = 0.0;     ///< how far a tilt is from the motion [rad]
  double dropped = 0.0;   ///< share of the times without a tilt
  std::size_t asked = 0;  ///< times from 1 s to 18 s
};
Bridged bridge(const Motion& motion, double rate, const std::function<bool(int)>& misses, double step = 0.0) {
  TiltTrack track;
  for (int i = 0; i <= 20 * rate; ++i) {
    const double angle = motion(i / rate);
    if (!misses(i)) track.add(i / rate, step > 0.0 ? step * std::round(angle / step) : angle);
  }
  Bridged result;
  for (double t = 1.0; t < 18.0; t += 0.0007) {
    ++result.asked;
    double angle = 0.0;
    const Status status = track.lookup(t, angle);
    if (status == Status::kReady)
      result.worst = std::max(result.worst, std::abs(angle - motion(t)));
    else
      result.dropped += 1.0;
  }
  result.dropped /= static_cast<double>(result.asked);
  return result;
}

TEST(TiltTrack, noGapIsBridgedWhereTheMotionMayLeaveTheLine) {
  for (const int length : {1, 2, 3, 5, 10, 20, 45}) {
    const auto misses = [&](int i) { return i % (2 * length + 33) < length; };  // all places of the motion, in time
    EXPECT_LT(bridge(nod, 100.0, misses).worst, 0.0005) << length;
    EXPECT_LT(bridge(zigzag, 100.0, misses).worst, 0.0005) << length;
    EXPECT_LT(bridge(nod, 50.0, misses).worst, 0.0005) << length;
  }
}

TEST(TiltTrack, gapsInARowAreNoBetterThanOne) {
  std::mt19937 random(7);
  for (const double lost : {0.1, 0.3, 0.5}) {
    const auto misses = [&](int) { return std::bernoulli_distribution(lost)(random); };
    EXPECT_LT(bridge(nod, 100.0, misses).worst, 0.0005) << lost;
    EXPECT_LT(bridge(zigzag, 100.0, misses).worst, 0.004) << lost;  // turning in half the intervals, nothing tells it
  }
}

TEST(TiltTrack, aSampleMissingNowAndThenCostsNothing) {
  const auto misses = [](int i) { return i % 20 == 7; };
  EXPECT_EQ(bridge(nod, 100.0, misses).dropped, 0.0);
  EXPECT_LT(bridge(zigzag, 100.0, misses).dropped, 0.001);
  EXPECT_EQ(bridge([](double t) { return nod(0.2 * t); }, 50.0, misses).dropped, 0.0);
}

TEST(TiltTrack, aLongGapInSteadyMotionIsBridged) {
  const auto misses = [](int i) { return i % 200 > 80 && i % 200 < 120; };
  const Bridged across = bridge([](double t) { return 0.3 * t; }, 100.0, misses);
  EXPECT_EQ(across.dropped, 0.0);
  EXPECT_LT(across.worst, 1e-9);
}

TEST(TiltTrack, aCoarseEncoderLosesFewLinesInGaps) {
  const auto misses = [](int i) { return i % 20 == 7; };
  const auto slow = [](double t) { return nod(0.2 * t); };
  for (const double step : {0.0017, 0.005}) {
    const Bridged across = bridge(slow, 100.0, misses, step);
    EXPECT_LT(across.dropped, 0.02) << step;  // a tenth of the time is in gaps
    EXPECT_LT(across.worst, 0.51 * step + 0.0005) << step;
  }
}

TEST(TiltTrack, aGapIsJudgedOnceTheMotionAfterItIsKnown) {
  TiltTrack track;
  for (int i = 0; i < 50; ++i) track.add(1.0 + 0.01 * i, 0.005 * i);
  double angle = 0.0;
  for (int i = 60; i < 71; ++i) {
    EXPECT_EQ(track.lookup(1.55, angle), Status::kTooNew) << i;
    EXPECT_EQ(track.lookup(1.485, angle), Status::kReady) << i;
    track.add(1.0 + 0.01 * i, 0.005 * i);
  }
  track.add(1.71, 0.355);
  ASSERT_EQ(track.lookup(1.55, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.275, 1e-12);
}

TEST(TiltTrack, theFirstSamplesAreJudgedByThoseAfterThem) {
  // Samples are missing between the first two, and again after a jump.
  TiltTrack track;
  track.add(1.0, 0.0);
  double angle = 0.0;
  for (int i = 0; i < 3; ++i) {
    track.add(1.3 + 0.01 * i, 0.1);
    EXPECT_EQ(track.lookup(1.1, angle), i == 0 ? Status::kTooNew : Status::kGap) << i;
    EXPECT_EQ(track.lookup(1.0, angle), Status::kReady);
  }
  track.add(1.33, 2.0);
  for (int i = 0; i < 5; ++i) track.add(1.43 + 0.01 * i, 2.1);
  EXPECT_EQ(track.counts().jumps, 1U);
  EXPECT_EQ(track.lookup(1.325, angle), Status::kGap);
  EXPECT_EQ(track.lookup(1.4, angle), Status::kGap);
  EXPECT_EQ(track.lookup(1.435, angle), Status::kReady);
  // None are missing here, which is known once three more have come.
  TiltTrack steady;
  steady.add(1.0, 0.0);
  for (int i = 1; i <= 4; ++i) {
    EXPECT_EQ(steady.lookup(1.005, angle), Status::kTooNew) << i;
    steady.add(1.0 + 0.01 * i, 0.01 * i);
  }
  ASSERT_EQ(steady.lookup(1.005, angle), Status::kReady);
  EXPECT_NEAR(angle, 0.005, 1e-12);
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
