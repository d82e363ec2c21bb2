// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/sweep_assembler.h"

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/tilt_pose_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace ppc {
namespace {

constexpr double kStart = 1000.0;

/// A laser of 181 beams on a motor that follows `angle(t)`; every range is 10 m.
struct Rig {
  explicit Rig(SweepOptions options = {}, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitY(),
               const Eigen::Isometry3d& mount = Eigen::Isometry3d::Identity())
      : source(axis, TiltTrackOptions{}), assembler(options, source, [this](Sweep&& s) { sweeps.push_back(std::move(s)); }) {
    source.setMount(mount);
  }
  ScanLine line(double stamp) const {
    ScanLine l;
    l.stamp = stamp;
    l.bearing_min = -M_PI / 2.0;
    l.bearing_increment = M_PI / 180.0;
    l.time_increment = 0.015 / 180.0;
    l.range_min = 0.1;
    l.range_max = 30.0;
    l.ranges.assign(181, 10.0F);
    return l;
  }
  void sample(double stamp) {
    source.track().add(stamp, angle(stamp));
    assembler.process();
  }
  /// Lines at 40 Hz and joint samples at 100 Hz, in the order of their stamps.
  void run(double from, double to) {
    for (int tick = static_cast<int>(std::lround(from * 200.0)); tick < static_cast<int>(std::lround(to * 200.0)); ++tick) {
      const double t = kStart + tick / 200.0;
      if (tick % 2 == 0) sample(t);
      if (tick % 5 != 0) continue;
      EXPECT_EQ(assembler.push(line(t)), "");
    }
  }
  void expectAccountsClose() const {
    const LineAccounts& a = assembler.accounts();
    EXPECT_EQ(a.lines_in, a.lines_in_images + a.pending + a.allDrops());
    std::uint64_t rows = 0;
    for (const Sweep& sweep : sweeps) rows += static_cast<std::uint64_t>(sweep.image.rows);
    EXPECT_EQ(a.lines_in_images, rows);
  }

  std::function<double(double)> angle = [](double t) { return -0.7 * std::cos(2.0 * M_PI * (t - kStart) / 4.0); };
  TiltPoseSource source;
  std::vector<Sweep> sweeps;
  SweepAssembler assembler;
};

double worstPointError(const Rig& rig, const Sweep& sweep, const Eigen::Vector3d& axis, const Eigen::Isometry3d& mount) {
  const BeamGrid grid = toBeamGrid(sweep.image);
  const ScanLine line = rig.line(0.0);
  double worst = 0.0;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const double tilt = rig.angle(sweep.image.row_stamps[r] + c * line.time_increment);
      const double bearing = line.bearing_min + c * line.bearing_increment;
      const Eigen::Vector3d in_laser(10.0 * std::cos(bearing), 10.0 * std::sin(bearing), 0.0);
      const Eigen::Vector3d truth = Eigen::AngleAxisd(tilt, axis) * (mount * in_laser);
      worst = std::max(worst, (grid.point(grid.index(r, c)).cast<double>() - truth).norm());
    }
  }
  return worst;
}

Eigen::Isometry3d leverArm() {
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  mount.linear() =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())).matrix();
  mount.translation() = Eigen::Vector3d(0.05, -0.02, 0.08);
  return mount;
}

TEST(SweepAssembler, noddingPointsMatchTheClosedFormWithinAMillimetreAtTenMetres) {
  Rig rig({}, Eigen::Vector3d::UnitY(), leverArm());
  rig.run(0.0, 8.2);
  ASSERT_EQ(rig.sweeps.size(), 4U);
  for (const Sweep& sweep : rig.sweeps) {
    EXPECT_GT(sweep.image.rows, 70);
    EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitY(), leverArm()), 0.001);
  }
  rig.expectAccountsClose();
}

TEST(SweepAssembler, spinningPointsMatchTheClosedFormWithinAMillimetreAtTenMetres) {
  for (const bool half : {true, false}) {
    SweepOptions options;
    options.motion = half ? SweepMotion::kHalfTurn : SweepMotion::kFullTurn;
    Rig rig(options, Eigen::Vector3d::UnitX(), leverArm());
    rig.angle = [](double t) { return 3.0 * (t - kStart) - M_PI; };  // a turn in 2.094 s, about 84 lines
    rig.run(0.0, 9.0);
    ASSERT_EQ(rig.sweeps.size(), half ? 8U : 4U);
    for (const Sweep& sweep : rig.sweeps) {
      EXPECT_NEAR(sweep.image.rows, half ? 42 : 84, 1);
      EXPECT_GE(sweep.image.tilts.front(), -M_PI - 0.02);
      EXPECT_LE(sweep.image.tilts.back(), M_PI + 0.02);
      EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitX(), leverArm()), 0.001);
    }
    rig.expectAccountsClose();
  }
}

void expectSameImage(const RangeImage& a, const RangeImage& b) {
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.ranges, b.ranges);
  EXPECT_EQ(a.tilts, b.tilts);
  EXPECT_EQ(a.row_stamps, b.row_stamps);
  ASSERT_EQ(a.line_poses.size(), b.line_poses.size());
  for (std::size_t i = 0; i < a.line_poses.size(); ++i) {
    ASSERT_EQ(a.line_poses[i].matrix(), b.line_poses[i].matrix()) << i;
  }
}

TEST(SweepAssembler, sweepsAreForeseenAsTheyWillBe) {
  for (const SweepMotion motion : {SweepMotion::kNodding, SweepMotion::kHalfTurn}) {
    SweepOptions options;
    options.motion = motion;
    Rig rig(options, Eigen::Vector3d::UnitY(), leverArm());
    if (motion == SweepMotion::kHalfTurn) rig.angle = [](double t) { return 3.0 * (t - kStart) - M_PI; };
    std::vector<Sweep> foreseen;
    std::vector<std::size_t> completed;  // when each was foreseen
    rig.assembler.foresee([&](Sweep&& sweep) {
      foreseen.push_back(std::move(sweep));
      completed.push_back(rig.sweeps.size());
    });
    rig.run(0.0, 8.2);
    ASSERT_GE(rig.sweeps.size(), 4U);
    ASSERT_GE(foreseen.size(), rig.sweeps.size());
    for (std::size_t i = 0; i < rig.sweeps.size(); ++i) {
      EXPECT_EQ(completed[i], i) << "not told before its end, or more than once";
      EXPECT_EQ(foreseen[i].stamp, rig.sweeps[i].stamp);
      expectSameImage(foreseen[i].image, rig.sweeps[i].image);
    }
    rig.expectAccountsClose();  // what is foreseen counts nowhere
  }
}

TEST(SweepAssembler, aTurnThatWasNoneIsForeseenInVain) {
  Rig rig;
  // Up, 10 mrad back within the hysteresis of 20, and up again.
  rig.angle = [](double t) {
    const double s = t - kStart;
    return s < 2.0 ? 0.2 * s : s < 2.2 ? 0.4 - 0.05 * (s - 2.0) : 0.39 + 0.2 * (s - 2.2);
  };
  int foreseen = 0;
  rig.assembler.foresee([&](Sweep&&) { ++foreseen; });
  rig.run(0.0, 4.0);
  EXPECT_EQ(foreseen, 1);
  EXPECT_TRUE(rig.sweeps.empty());
  EXPECT_GT(rig.assembler.close(SweepEnd::kRequest), 150);  // all of it is one sweep
}

TEST(SweepAssembler, rowsAscendInBothDirectionsAndTheGridIsTheSame) {
  SweepOptions options;
  Rig rig(options);
  // Triangle of 0.01 rad a line; the same tilts up and down.
  rig.angle = [](double t) { return 0.7 - std::abs(std::fmod((t - kStart) * 0.4, 2.8) - 1.4); };
  rig.run(0.0, 11.0);
  ASSERT_EQ(rig.sweeps.size(), 3U);
  for (const Sweep& sweep : rig.sweeps) {
    EXPECT_TRUE(std::is_sorted(sweep.image.tilts.begin(), sweep.image.tilts.end()));
    EXPECT_EQ(sweep.end, SweepEnd::kTurn);
    EXPECT_NEAR(sweep.image.rows, 140, 1);
    EXPECT_NEAR(sweep.image.tilts.front(), -0.69, 0.02);
    EXPECT_NEAR(sweep.image.tilts.back(), 0.69, 0.02);
  }
  EXPECT_LT(rig.sweeps[0].image.row_stamps.front(), rig.sweeps[0].image.row_stamps.back());
  EXPECT_GT(rig.sweeps[1].image.row_stamps.front(), rig.sweeps[1].image.row_stamps.back());
  EXPECT_NEAR(rig.sweeps[1].stamp, rig.sweeps[1].image.row_stamps.front() + 0.015, 1e-9);
}

TEST(SweepAssembler, linesWaitForTheirSamplesAndAreNeverExtrapolated) {
  Rig rig;
  for (const double t : {-0.03, -0.02, -0.01, 0.0}) rig.sample(kStart + t);
  rig.assembler.push(rig.line(kStart + 0.005));  // lasts until 0.020
  rig.sample(kStart + 0.01);
  EXPECT_EQ(rig.assembler.openLines(), 0);
  ASSERT_NE(rig.assembler.oldestWaiting(), nullptr);
  rig.sample(kStart + 0.021);
  EXPECT_EQ(rig.assembler.openLines(), 1);
  EXPECT_EQ(rig.assembler.oldestWaiting(), nullptr);
}

TEST(SweepAssembler, linesInATiltGapAreDroppedByCause) {
  Rig rig;
  rig.run(0.0, 1.0);
  for (int i = 0; i < 28; ++i) rig.assembler.push(rig.line(kStart + 1.0 + 0.025 * i));  // no samples for 0.7 s
  rig.run(1.7, 1.9);
  EXPECT_NEAR(static_cast<double>(rig.assembler.accounts().drops(DropCause::kTiltGap)), 28.0, 1.0);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, linesThatNoSampleWillReachAreDroppedAndTheQueueIsBounded) {
  SweepOptions options;
  options.max_queue = 20;
  Rig rig(options);
  for (int i = 0; i < 100; ++i) rig.assembler.push(rig.line(kStart + 0.025 * i));
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kQueueFull), 80U);
  rig.sample(kStart + 50.0);
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kNoTilt), 20U);
  EXPECT_EQ(rig.assembler.accounts().pending, 0U);
  rig.assembler.push(rig.line(kStart + 60.0));  // far ahead of the newest sample
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kNoTilt), 21U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, waitsForTheMount) {
  SweepOptions options;
  TiltPoseSource source(Eigen::Vector3d::UnitY(), {});
  SweepAssembler assembler(options, source, [](Sweep&&) {});
  Rig rig;
  for (int i = 0; i < 10; ++i) source.track().add(kStart + 0.1 * i, 0.1 * i);
  assembler.push(rig.line(kStart + 0.2));
  EXPECT_EQ(assembler.openLines(), 0);
  source.setMount(leverArm());
  assembler.process();
  EXPECT_EQ(assembler.openLines(), 1);
}

TEST(SweepAssembler, aReorderedLineInTheQueueIsPutInPlaceALateOneDropped) {
  Rig rig;
  for (const double t : {-0.3, -0.2, -0.1, 0.0}) rig.sample(kStart + t);
  rig.assembler.push(rig.line(kStart + 0.050));
  rig.assembler.push(rig.line(kStart + 0.025));
  rig.assembler.push(rig.line(kStart + 0.025));
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kDuplicate), 1U);
  rig.sample(kStart + 0.1);
  EXPECT_EQ(rig.assembler.openLines(), 2);
  rig.assembler.push(rig.line(kStart + 0.030));
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kOutOfOrder), 1U);
  rig.assembler.push(rig.line(kStart + 0.050));
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kDuplicate), 2U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, aChangeOfLayoutStartsANewSweep) {
  Rig rig;
  rig.run(0.2, 1.0);
  ScanLine other = rig.line(kStart + 1.0);
  other.ranges.resize(91);
  rig.assembler.push(other);
  for (const double t : {1.0, 1.01, 1.02}) rig.sample(kStart + t);
  EXPECT_EQ(rig.assembler.accounts().layout_changes, 1U);
  ASSERT_EQ(rig.sweeps.size(), 1U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kLayoutChange);
  EXPECT_EQ(rig.sweeps[0].image.cols, 181);
  EXPECT_EQ(rig.assembler.openLines(), 1);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, aStandingMotorNeitherGrowsNorRepeatsASweep) {
  SweepOptions options;
  options.standing_lines = 20;
  Rig rig(options);
  rig.angle = [](double t) { return 0.4 * std::min(t - kStart, 1.5); };  // stands from 1.5 s on
  rig.run(0.0, 20.0);
  ASSERT_EQ(rig.sweeps.size(), 1U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kStanding);
  EXPECT_NEAR(rig.sweeps[0].image.rows, 60, 2);
  EXPECT_NEAR(rig.sweeps[0].image.tilts.back(), 0.59, 0.011);
  EXPECT_TRUE(rig.assembler.standing());
  EXPECT_EQ(rig.assembler.openLines(), 0);
  EXPECT_GT(rig.assembler.accounts().drops(DropCause::kTiltStanding), 730U);
  rig.expectAccountsClose();
  rig.angle = [](double t) { return 0.6 + 0.4 * (t - kStart - 20.0); };
  rig.run(20.0, 21.0);
  EXPECT_FALSE(rig.assembler.standing());
  EXPECT_NEAR(rig.assembler.openLines(), 39, 3);
}

TEST(SweepAssembler, aSweepIsClosedAtItsMostLinesAndOnRequest) {
  SweepOptions options;
  options.max_lines = 30;
  Rig rig(options);
  rig.run(0.3, 1.85);
  ASSERT_EQ(rig.sweeps.size(), 2U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kMaxLines);
  EXPECT_EQ(rig.sweeps[0].image.rows, 30);
  EXPECT_EQ(rig.sweeps[1].image.rows, 30);
  EXPECT_EQ(rig.assembler.close(SweepEnd::kRequest), 0);  // one line is no sweep
  rig.run(1.0 + 0.85, 1.9);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, closeReturnsTheRows) {
  Rig rig;
  EXPECT_EQ(rig.assembler.close(SweepEnd::kRequest), 0);
  rig.run(0.4, 1.4);
  EXPECT_EQ(rig.assembler.close(SweepEnd::kRequest), 40);
  ASSERT_EQ(rig.sweeps.size(), 1U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kRequest);
  EXPECT_EQ(rig.assembler.accounts().pending, 0U);
}

TEST(SweepAssembler, tooSmallASweepIsDroppedByCause) {
  Rig rig;
  rig.run(0.5, 0.65);
  rig.assembler.close(SweepEnd::kRequest);
  EXPECT_TRUE(rig.sweeps.empty());
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kSweepTooSmall), 6U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, twoPassesNeverShareAnImageAcrossAPause) {
  Rig rig;
  rig.run(0.3, 1.0);
  rig.run(4.9, 5.4);  // the next upward pass
  ASSERT_EQ(rig.sweeps.size(), 1U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kLineGap);
  EXPECT_NEAR(rig.sweeps[0].image.rows, 28, 1);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, aClockThatJumpsBackDropsTheOpenSweepAndGoesOn) {
  Rig rig;
  rig.run(0.0, 5.0);
  ASSERT_EQ(rig.sweeps.size(), 2U);
  rig.run(0.0, 5.0);  // a bag that loops
  EXPECT_EQ(rig.assembler.accounts().clock_resets, 1U);
  EXPECT_GT(rig.assembler.accounts().drops(DropCause::kClockReset), 30U);
  EXPECT_EQ(rig.sweeps.size(), 4U);
  for (const Sweep& sweep : rig.sweeps) {
    EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitY(), Eigen::Isometry3d::Identity()), 0.001);
  }
  rig.expectAccountsClose();
}

TEST(SweepAssembler, aClockThatJumpsForwardEndsTheSweepAndGoesOn) {
  Rig rig;
  rig.run(0.0, 1.0);
  rig.run(1000.0, 1005.0);
  ASSERT_EQ(rig.sweeps.size(), 3U);
  EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kLineGap);
  EXPECT_EQ(rig.sweeps[1].end, SweepEnd::kTurn);
  EXPECT_EQ(rig.assembler.accounts().clock_resets, 0U);
  EXPECT_LE(rig.assembler.accounts().allDrops(), 4U);  // before the jump is confirmed
  for (const Sweep& sweep : rig.sweeps) {
    EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitY(), Eigen::Isometry3d::Identity()), 0.001);
  }
  rig.expectAccountsClose();
}

TEST(SweepAssembler, samplesLateByHalfASecondLoseNoLine) {
  Rig rig;
  for (int tick = 0; tick < 1000; ++tick) {
    const double t = kStart + tick / 200.0;
    if (tick % 2 == 0 && tick >= 100) rig.sample(t - 0.5);
    if (tick % 5 == 0) rig.assembler.push(rig.line(t));
  }
  ASSERT_EQ(rig.sweeps.size(), 2U);
  EXPECT_EQ(rig.assembler.accounts().allDrops(), 0U);
  EXPECT_LT(worstPointError(rig, rig.sweeps[1], Eigen::Vector3d::UnitY(), Eigen::Isometry3d::Identity()), 0.001);
  rig.expectAccountsClose();
}

/// Lines and samples of 9 s, the samples `joint_delay` and the lines `line_delay` late, in bursts of `burst` ticks of 5 ms.
std::vector<Sweep> sweepsOf(const std::function<double(double)>& angle, int joint_delay, int line_delay, int burst) {
  Rig rig;
  rig.angle = angle;
  const auto arrived = [burst](int now, int delay, int stamp) { return (now - delay) / burst * burst >= stamp; };
  int next_sample = 0, next_line = 0;
  for (int now = 0; now < 1800 + joint_delay + line_delay + burst; ++now) {
    for (; next_line < 1800 && arrived(now, line_delay, next_line); next_line += 5) {
      EXPECT_EQ(rig.assembler.push(rig.line(kStart + next_line / 200.0)), "");
    }
    for (; next_sample < 1800 && arrived(now, joint_delay, next_sample); next_sample += 2) {
      rig.sample(kStart + next_sample / 200.0);
    }
  }
  rig.assembler.close(SweepEnd::kIdle);
  rig.expectAccountsClose();
  return std::move(rig.sweeps);
}

TEST(SweepAssembler, sweepsDependOnStampsAloneAndNotOnTheOrderOfArrival) {
  const auto nod = Rig().angle;
  const std::vector<std::function<double(double)>> motions = {
      nod,
      [&](double t) { return nod(std::abs(t - kStart - 3.0) < 0.3 ? kStart + 2.7 : t); },  // frozen for 0.6 s
      [&](double t) { return nod(t) + (t > kStart + 4.7 ? 0.8 : 0.0); },                   // the encoder jumps
      [&](double t) { return std::remainder(nod(t) + M_PI, 2.0 * M_PI); },
  };
  const int orders[][3] = {{0, 40, 1}, {60, 0, 1}, {0, 0, 20}, {50, 10, 7}};
  for (std::size_t m = 0; m < motions.size(); ++m) {
    const std::vector<Sweep> expected = sweepsOf(motions[m], 0, 0, 1);
    ASSERT_GE(expected.size(), 5U);
    for (const auto& [joint_delay, line_delay, burst] : orders) {
      SCOPED_TRACE("motion " + std::to_string(m) + ", delays " + std::to_string(joint_delay) + " and " +
                   std::to_string(line_delay) + ", burst " + std::to_string(burst));
      const std::vector<Sweep> sweeps = sweepsOf(motions[m], joint_delay, line_delay, burst);
      ASSERT_EQ(sweeps.size(), expected.size());
      for (std::size_t i = 0; i < sweeps.size(); ++i) {
        EXPECT_EQ(sweeps[i].end, expected[i].end);
        EXPECT_EQ(sweeps[i].stamp, expected[i].stamp);
        EXPECT_EQ(sweeps[i].image.tilts, expected[i].image.tilts);
        EXPECT_EQ(sweeps[i].image.row_stamps, expected[i].image.row_stamps);
        ASSERT_EQ(sweeps[i].image.line_poses.size(), expected[i].image.line_poses.size());
        for (std::size_t k = 0; k < sweeps[i].image.line_poses.size(); ++k) {
          ASSERT_EQ(sweeps[i].image.line_poses[k].matrix(), expected[i].image.line_poses[k].matrix());
        }
        EXPECT_EQ(sweeps[i].accounts.lines_in, expected[i].accounts.lines_in);
        EXPECT_EQ(sweeps[i].accounts.pending, expected[i].accounts.pending);
        EXPECT_EQ(sweeps[i].accounts.dropped, expected[i].accounts.dropped);
        EXPECT_EQ(sweeps[i].accounts.lines_in,
                  sweeps[i].accounts.lines_in_images + sweeps[i].accounts.pending + sweeps[i].accounts.allDrops());
      }
    }
  }
}

TEST(SweepAssembler, aJointThatFallsSilentIsGivenUpAfterAWhile) {
  Rig rig;
  rig.run(0.0, 1.0);
  for (int i = 0; i < 400; ++i) rig.assembler.push(rig.line(kStart + 1.0 + 0.025 * i));
  EXPECT_GT(rig.assembler.accounts().drops(DropCause::kNoTilt) + rig.assembler.accounts().drops(DropCause::kQueueFull),
            150U);
  EXPECT_LE(rig.assembler.accounts().pending, 240U);
  EXPECT_EQ(rig.assembler.openLines(), 40);  // not one line was placed without a sample
  rig.expectAccountsClose();
}

TEST(SweepAssembler, aFrozenEncoderCostsItsLinesAndEndsTheSweep) {
  for (const double frozen_for : {0.1, 0.5, 1.5}) {
    Rig rig;
    const auto truth = rig.angle;
    rig.run(0.0, 0.8);
    rig.angle = [=](double) { return truth(kStart + 0.79); };
    rig.run(0.8, 0.8 + frozen_for);
    rig.angle = truth;
    rig.run(0.8 + frozen_for, 5.0);
    rig.assembler.close(SweepEnd::kRequest);
    // Those of the frozen time and one or two at its borders; none of them is in an image.
    EXPECT_NEAR(static_cast<double>(rig.assembler.accounts().drops(DropCause::kTiltGap)), 40.0 * frozen_for, 2.0);
    ASSERT_EQ(rig.sweeps.size(), frozen_for < 1.2 ? 4U : 3U) << frozen_for;  // the motor turns at 2 s
    EXPECT_EQ(rig.sweeps[0].end, SweepEnd::kTiltJump);
    for (const Sweep& sweep : rig.sweeps) {
      EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitY(), Eigen::Isometry3d::Identity()), 0.002);
    }
    rig.expectAccountsClose();
  }
}

TEST(SweepAssembler, aPoseThatNeverComesIsGivenUpByTheLinesClock) {
  SweepOptions options;
  options.max_wait = 2.0;
  Rig rig(options);
  TiltPoseSource source(Eigen::Vector3d::UnitY(), {});  // without a mount
  for (int i = 0; i < 1000; ++i) source.track().add(kStart + 0.01 * i, 0.001 * i);
  SweepAssembler assembler(options, source, [](Sweep&&) {});
  for (int i = 1; i <= 79; ++i) assembler.push(rig.line(kStart + 0.025 * i));
  EXPECT_EQ(assembler.accounts().allDrops(), 0U);
  EXPECT_EQ(assembler.waitsFor(), PoseStatus::kWaitTransform);
  for (int i = 80; i <= 200; ++i) assembler.push(rig.line(kStart + 0.025 * i));
  EXPECT_NEAR(static_cast<double>(assembler.accounts().pending), 82.0, 2.0);
  EXPECT_EQ(assembler.accounts().drops(DropCause::kNoTransform), assembler.accounts().allDrops());
  assembler.push(rig.line(kStart + 5.1));
  assembler.push(rig.line(kStart + 1e5));  // two strays do not make the others late
  assembler.push(rig.line(kStart + 2e5));
  EXPECT_NEAR(static_cast<double>(assembler.accounts().pending), 82.0, 2.0);
  source.setMount(leverArm());
  assembler.process();
  EXPECT_EQ(assembler.waitsFor(), PoseStatus::kReady);
  EXPECT_NEAR(assembler.openLines(), 82.0, 2.0);
  EXPECT_EQ(assembler.accounts().lines_in, assembler.accounts().pending + assembler.accounts().allDrops());
}

TEST(SweepAssembler, aClockThatJumpsBackForgetsTheTiltOfTheOtherRun) {
  Rig rig;
  rig.run(0.0, 8.0);
  // The lines' clock is seen to jump before the joint's: no line may use a sample of the first run.
  for (int i = 0; i < 4; ++i) rig.assembler.push(rig.line(kStart + 3.0 + 0.025 * i));
  EXPECT_EQ(rig.assembler.accounts().clock_resets, 1U);
  EXPECT_EQ(rig.assembler.openLines(), 0);
  EXPECT_TRUE(rig.source.track().empty());
  rig.run(3.1, 9.0);
  for (const Sweep& sweep : rig.sweeps) {
    EXPECT_LT(worstPointError(rig, sweep, Eigen::Vector3d::UnitY(), Eigen::Isometry3d::Identity()), 0.001);
  }
  rig.expectAccountsClose();
}

TEST(SweepAssembler, oneStrayStampNeitherResetsNorBlocks) {
  Rig rig;
  rig.run(0.0, 1.0);
  rig.assembler.push(rig.line(5.0));
  rig.assembler.push(rig.line(kStart + 1e6));
  rig.run(1.0, 3.0);
  EXPECT_EQ(rig.assembler.accounts().clock_resets, 0U);
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kOutOfOrder), 1U);
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kNoTilt), 1U);
  EXPECT_EQ(rig.sweeps.size(), 1U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, linesFromTheFarFutureDoNotStarveTheQueue) {
  SweepOptions options;
  options.max_queue = 30;
  Rig rig(options);
  for (int i = 0; i < 30; ++i) rig.assembler.push(rig.line(kStart + 1e5 + i));  // before the first sample: they wait
  rig.run(0.0, 3.0);
  EXPECT_EQ(rig.sweeps.size(), 1U);
  EXPECT_NEAR(static_cast<double>(rig.assembler.accounts().lines_in_images), 81.0, 2.0);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, badLinesAreNamedCountedAndSkipped) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(ScanLine&)>>> faults = {
      {"ranges are empty", [](ScanLine& l) { l.ranges.clear(); }},
      {"intensities", [](ScanLine& l) { l.intensities.resize(3); }},
      {"stamp", [nan](ScanLine& l) { l.stamp = nan; }},
      {"stamp", [](ScanLine& l) { l.stamp = 0.0; }},
      {"time_increment is not finite", [nan](ScanLine& l) { l.time_increment = nan; }},
      {"time_increment is negative", [](ScanLine& l) { l.time_increment = -1e-5; }},
      {"too long", [](ScanLine& l) { l.time_increment = 1.0; }},
      {"angle_min", [nan](ScanLine& l) { l.bearing_min = nan; }},
      {"angle_increment is not finite", [nan](ScanLine& l) { l.bearing_increment = nan; }},
      {"angle_increment is zero", [](ScanLine& l) { l.bearing_increment = 0.0; }},
      {"wider than a turn", [](ScanLine& l) { l.bearing_increment = 0.1; }},
      {"range_min", [nan](ScanLine& l) { l.range_min = nan; }},
      {"range_max", [](ScanLine& l) { l.range_max = 0.05; }},
      {"range_max", [nan](ScanLine& l) { l.range_max = nan; }},
  };
  Rig rig;
  for (const auto& [words, spoil] : faults) {
    ScanLine line = rig.line(kStart + 0.1);
    spoil(line);
    EXPECT_NE(rig.assembler.push(line).find(words), std::string::npos) << words;
  }
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kBadScan), faults.size());
  EXPECT_EQ(rig.assembler.accounts().pending, 0U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, valuesOfRangesPassUnchanged) {
  Rig rig;
  const float inf = std::numeric_limits<float>::infinity();
  rig.sample(kStart);
  for (int i = 0; i < 40; ++i) {
    ScanLine line = rig.line(kStart + 0.025 * i);
    line.ranges[0] = std::numeric_limits<float>::quiet_NaN();
    line.ranges[1] = inf;
    line.ranges[2] = -inf;
    line.ranges[3] = 0.0F;
    line.ranges[4] = -1.0F;
    line.intensities.assign(181, static_cast<float>(i));
    rig.assembler.push(line);
    rig.sample(kStart + 0.025 * (i + 1));
  }
  ASSERT_EQ(rig.assembler.close(SweepEnd::kRequest), 40);
  const RangeImage& image = rig.sweeps[0].image;
  EXPECT_TRUE(std::isnan(image.ranges[181]));
  EXPECT_EQ(image.ranges[182], inf);
  EXPECT_EQ(image.ranges[183], -inf);
  EXPECT_EQ(image.ranges[184], 0.0F);
  EXPECT_EQ(image.ranges[185], -1.0F);
  EXPECT_EQ(image.intensities[181 * 7], 7.0F);
  EXPECT_EQ(toBeamGrid(image).valid(181 + 3), false);
}

TEST(SweepAssembler, skipLeavesOutLinesAndCountsThem) {
  SweepOptions options;
  options.skip = 3;
  Rig rig(options);
  rig.run(0.0, 2.4);
  ASSERT_EQ(rig.sweeps.size(), 1U);
  EXPECT_NEAR(rig.sweeps[0].image.rows, 21, 1);
  EXPECT_EQ(rig.assembler.accounts().drops(DropCause::kSkipped), 72U);
  rig.expectAccountsClose();
}

TEST(SweepAssembler, accountsCloseAndPointsStayTrueUnderRandomFaults) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    SweepOptions options;
    options.max_queue = 40;
    Rig rig(options, Eigen::Vector3d::UnitY(), leverArm());
    const double drop = 0.5 * chance(random);
    std::vector<ScanLine> burst;
    double silent_until = 0.0;
    for (int tick = 0; tick < 4000; ++tick) {
      const double t = kStart + tick / 200.0;
      if (chance(random) < 0.001) silent_until = t + 2.0 * chance(random);
      if (tick % 2 == 0 && t > silent_until && chance(random) > drop) {
        rig.sample(chance(random) < 0.02 ? t - 0.05 : t);
        if (chance(random) < 0.02) rig.source.track().add(t + 1e-4, 3.0 * chance(random) - 1.5);  // glitch
      }
      if (tick % 5 != 0 || chance(random) < drop) continue;
      burst.push_back(rig.line(t));
      if (chance(random) < 0.05) burst.push_back(rig.line(t));
      if (chance(random) < 0.05) burst.back().time_increment = -1.0;
      if (chance(random) < 0.02) burst.back().stamp -= 2000.0 * (chance(random) - 0.5);
      if (burst.size() < 6 && chance(random) < 0.7) continue;
      std::shuffle(burst.begin(), burst.end(), random);
      for (ScanLine& line : burst) rig.assembler.push(line);
      burst.clear();
    }
    rig.assembler.close(SweepEnd::kRequest);
    EXPECT_LE(rig.assembler.accounts().pending, 42U);
    rig.expectAccountsClose();
    EXPECT_GE(rig.sweeps.size(), 4U);
    for (const Sweep& sweep : rig.sweeps) {
      EXPECT_TRUE(std::is_sorted(sweep.image.tilts.begin(), sweep.image.tilts.end()));
      const auto [first, last] = std::minmax_element(sweep.image.row_stamps.begin(), sweep.image.row_stamps.end());
      EXPECT_LT(*last - *first, 2.4);  // one pass
      for (int r = 0; r < sweep.image.rows; ++r) {
        // What a gap just short of the longest and a glitch just below the plausible speed can do together.
        EXPECT_NEAR(sweep.image.tilts[r], rig.angle(sweep.image.row_stamps[r] + 0.0075), 0.12);
      }
    }
  }
}

/// A base that drives along x at 1 m/s while the laser nods.
class DrivingSource : public PoseSource {
 public:
  PoseStatus at(double stamp, LaserPose& pose) override {
    const double t = stamp - kStart;
    if (t < 0.0) return PoseStatus::kNoTransform;
    if (t > known_until) return PoseStatus::kWait;
    pose.tilt = 0.4 * t;
    pose.base = Eigen::Isometry3d(Eigen::Translation3d(t, 0.0, 0.0));
    pose.pose = pose.base * Eigen::AngleAxisd(pose.tilt, Eigen::Vector3d::UnitY());
    return PoseStatus::kReady;
  }
  double known_until = 0.0;
};

TEST(SweepAssembler, aMovingBaseIsReferredToTheNewestBeam) {
  DrivingSource source;
  std::vector<Sweep> sweeps;
  SweepAssembler assembler({}, source, [&](Sweep&& s) { sweeps.push_back(std::move(s)); });
  const Rig rig;
  assembler.push(rig.line(kStart - 0.5));
  for (int i = 0; i < 40; ++i) assembler.push(rig.line(kStart + 0.025 * i));
  EXPECT_EQ(assembler.openLines(), 0);
  source.known_until = 0.5;
  assembler.process();
  EXPECT_EQ(assembler.openLines(), 20);
  source.known_until = 2.0;
  assembler.process();
  ASSERT_EQ(assembler.close(SweepEnd::kRequest), 40);
  EXPECT_EQ(assembler.accounts().drops(DropCause::kNoTransform), 1U);
  const RangeImage& image = sweeps[0].image;
  EXPECT_NEAR(sweeps[0].stamp, kStart + 39 * 0.025 + 0.015, 1e-9);
  // The first line's first beam was taken where the base was 0.99 m behind its last position.
  EXPECT_NEAR(image.line_poses.front().translation().x(), -(39 * 0.025 + 0.015), 1e-9);
  EXPECT_NEAR(image.line_poses.back().translation().x(), 0.0, 1e-9);
}

}  // namespace
}  // namespace ppc
