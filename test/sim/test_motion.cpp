// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/motion.h"

#include <gtest/gtest.h>
#include <cmath>
#include <stdexcept>

namespace ppc::sim {
namespace {

TEST(Motion, NoddingSwingsBetweenItsTurningPoints) {
  Motion m;
  m.centre = 0.2;
  m.amplitude = 1.0;
  constexpr double kPass = 7.5;
  EXPECT_NEAR(m.tilt(0.0, kPass), -0.8, 1e-12);
  EXPECT_NEAR(m.tilt(0.5 * kPass, kPass), 0.2, 1e-12);
  EXPECT_NEAR(m.tilt(kPass, kPass), 1.2, 1e-12);
  EXPECT_NEAR(m.tilt(2 * kPass, kPass), -0.8, 1e-12);
  EXPECT_TRUE(m.ascending(0.1, kPass));
  EXPECT_FALSE(m.ascending(kPass + 0.1, kPass));
  // Down is up backwards.
  for (const double t : {0.3, 1.0, 4.0, 7.2}) EXPECT_NEAR(m.tilt(kPass + t, kPass), m.tilt(kPass - t, kPass), 1e-12);
}

TEST(Motion, NoddingSpeedIsContinuousAndConstantInBetween) {
  const Motion m;
  constexpr double kPass = 7.5, kStep = 1e-4;
  const double top = 2.0 * m.amplitude / (kPass * (1.0 - m.turn_share));
  double previous = 0.0;
  for (double t = kStep; t < 2.0 * kPass; t += kStep) {
    const double speed = (m.tilt(t + kStep, kPass) - m.tilt(t, kPass)) / kStep;
    ASSERT_LE(std::abs(speed), top * (1 + 1e-6));
    ASSERT_NEAR(speed, previous, 1e-3) << "at " << t;
    previous = speed;
    const double phase = std::fmod(t, kPass) / kPass;
    if (phase > 0.11 && phase < 0.89) {
      ASSERT_NEAR(std::abs(speed), top, 1e-6);
    }
  }
}

TEST(Motion, SpinningTurnsEvenlyWithoutWrapping) {
  Motion m;
  m.kind = Motion::Kind::kSpinning;
  for (const double passes : {0.0, 0.25, 1.0, 2.5, 10.0}) {
    EXPECT_NEAR(m.tilt(passes * 3.0, 3.0), passes * M_PI, 1e-12);
    EXPECT_TRUE(m.ascending(passes * 3.0, 3.0));
  }
}

TEST(Motion, NamesAreChecked) {
  EXPECT_EQ(axisFromName("roll"), Eigen::Vector3d::UnitX());
  EXPECT_EQ(axisFromName("pitch"), Eigen::Vector3d::UnitY());
  EXPECT_EQ(axisFromName("yaw"), Eigen::Vector3d::UnitZ());
  EXPECT_THROW(axisFromName("tilt"), std::invalid_argument);
  EXPECT_EQ(motionFromName("spinning"), Motion::Kind::kSpinning);
  EXPECT_THROW(motionFromName("still"), std::invalid_argument);
}

}  // namespace
}  // namespace ppc::sim
