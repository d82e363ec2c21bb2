// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/sweep_splitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace ppc {
namespace {

// Lengths of the completed sweeps.
std::vector<std::size_t> split(SweepMotion motion, const std::vector<double>& tilts, double hysteresis = 0.02) {
  SweepSplitter splitter(motion, hysteresis);
  std::vector<std::size_t> sweeps;
  for (const double tilt : tilts) {
    const std::size_t n = splitter.feed(tilt);
    if (n > 0) sweeps.push_back(n);
  }
  return sweeps;
}

std::vector<double> triangle(int lines_a_way, double step, int ways) {
  std::vector<double> tilts{0.0};
  for (int way = 0; way < ways; ++way) {
    for (int i = 0; i < lines_a_way; ++i) tilts.push_back(tilts.back() + (way % 2 == 0 ? step : -step));
  }
  return tilts;
}

TEST(SweepSplitter, nodsEndAtTheExtremum) {
  // 0 .. 1.0 in 101 lines; the way back begins after the extremum.
  EXPECT_EQ(split(SweepMotion::kNodding, triangle(100, 0.01, 4)), (std::vector<std::size_t>{101, 100, 100}));
}

TEST(SweepSplitter, startingDownwardsWorksTheSame) {
  EXPECT_EQ(split(SweepMotion::kNodding, triangle(100, -0.01, 4)), (std::vector<std::size_t>{101, 100, 100}));
}

TEST(SweepSplitter, encoderNoiseAtTurningPointsMakesNoSweeps) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.0025);
  std::vector<double> tilts;
  for (int i = 0; i < 4000; ++i) tilts.push_back(-0.7 * std::cos(2.0 * M_PI * i / 400.0) + noise(random));
  const auto sweeps = split(SweepMotion::kNodding, tilts, 0.03);
  ASSERT_EQ(sweeps.size(), 19U);  // 20 half periods, the last one is open
  for (const std::size_t n : sweeps) EXPECT_NEAR(static_cast<double>(n), 200.0, 40.0);
}

TEST(SweepSplitter, aMotionWithinTheHysteresisIsNoTurn) {
  EXPECT_TRUE(split(SweepMotion::kNodding, triangle(19, 0.001, 50)).empty());
}

TEST(SweepSplitter, halfTurnsEndAtMultiplesOfPi) {
  std::vector<double> tilts;
  for (int i = 0; i < 350; ++i) tilts.push_back(0.005 + 0.01 * M_PI * i);  // 100 lines a half turn
  EXPECT_EQ(split(SweepMotion::kHalfTurn, tilts), (std::vector<std::size_t>{100, 100, 100}));
}

TEST(SweepSplitter, fullTurnsEndOppositeToZeroInBothSenses) {
  std::vector<double> tilts;
  for (int i = 0; i < 450; ++i) tilts.push_back(0.005 + 0.01 * M_PI * i);  // 200 lines a turn
  EXPECT_EQ(split(SweepMotion::kFullTurn, tilts), (std::vector<std::size_t>{100, 200}));
  for (double& tilt : tilts) tilt = -tilt;
  EXPECT_EQ(split(SweepMotion::kFullTurn, tilts), (std::vector<std::size_t>{100, 200}));
}

TEST(SweepSplitter, noiseAtTheBorderOfATurnMakesNoSweeps) {
  const std::vector<double> tilts{2.9, 3.0, 3.1, 3.1445, 3.139, 3.143, 3.138, 3.16, 3.2};
  EXPECT_EQ(split(SweepMotion::kFullTurn, tilts), (std::vector<std::size_t>{3}));
}

// What is foreseen while a completed sweep comes to its end: how many lines before, and whether it was right.
struct Foreseen {
  int right = 0, wrong = 0;
  std::size_t fewest_lines_ahead = 1000;
};

Foreseen foresee(SweepMotion motion, const std::vector<double>& tilts, double hysteresis = 0.02) {
  SweepSplitter splitter(motion, hysteresis);
  Foreseen result;
  std::size_t foreseen = 0, since = 0;
  for (const double tilt : tilts) {
    const std::size_t completed = splitter.feed(tilt);
    if (completed > 0) {
      (completed == foreseen ? result.right : result.wrong) += 1;
      result.fewest_lines_ahead = std::min(result.fewest_lines_ahead, since);
    }
    ++since;
    if (splitter.foreseen() != 0 && splitter.foreseen() != foreseen) since = 1;
    foreseen = splitter.foreseen();
  }
  return result;
}

TEST(SweepSplitter, turningPointsAreForeseenOnceTheTiltHasComeBackByAQuarter) {
  // Steps of 2 mrad: seen to have come back after 6, certain after 20 to 22.
  const Foreseen result = foresee(SweepMotion::kNodding, triangle(500, 0.002, 4));
  EXPECT_EQ(result.right, 3);
  EXPECT_EQ(result.wrong, 0);
  EXPECT_GE(result.fewest_lines_ahead, 7U);
}

TEST(SweepSplitter, noiseAmidASweepForeseesNothing) {
  SweepSplitter splitter(SweepMotion::kNodding, 0.02);
  for (int i = 0; i < 200; ++i) {
    splitter.feed(0.01 * i - (i % 2 == 0 ? 0.012 : 0.0));  // comes back by 2 mrad at every second line
    EXPECT_EQ(splitter.foreseen(), 0U) << i;
  }
  splitter.feed(1.98);  // by 10 mrad
  EXPECT_EQ(splitter.foreseen(), 200U);
  splitter.feed(2.0);  // and goes on
  EXPECT_EQ(splitter.foreseen(), 0U);
}

TEST(SweepSplitter, theEndOfATurnIsForeseenOneLineBeforeInBothSenses) {
  for (const double sense : {1.0, -1.0}) {
    std::vector<double> tilts;
    for (int i = 0; i < 450; ++i) tilts.push_back(sense * (0.005 + 0.01 * M_PI * i));
    const Foreseen result = foresee(SweepMotion::kHalfTurn, tilts);
    EXPECT_EQ(result.right, 4);
    EXPECT_EQ(result.wrong, 0);
    EXPECT_EQ(result.fewest_lines_ahead, 1U);
  }
}

TEST(SweepSplitter, restartForgetsTheOpenSweep) {
  SweepSplitter splitter(SweepMotion::kNodding, 0.02);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(splitter.feed(0.01 * i), 0U);
  splitter.restart();
  EXPECT_EQ(splitter.foreseen(), 0U);
  EXPECT_EQ(splitter.feed(0.0), 0U);  // far below the old extremum, yet no turn
  EXPECT_EQ(splitter.feed(0.01), 0U);
}

}  // namespace
}  // namespace ppc
