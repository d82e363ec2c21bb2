// SPDX-License-Identifier: BSD-3-Clause
// The driver's assembly against the simulator's truth: what comes out of lines and joint samples is where it really was.
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/sweep_assembler.h"
#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/sim/scan_stream.h"

#include <gtest/gtest.h>
#include <cmath>
#include <ostream>

namespace ppc {
namespace {

struct Motor {
  std::string name;
  sim::Motion::Kind kind;
  std::string axis;
  Eigen::Vector3d rpy;
  double pass_angle;
  SweepMotion sweeps;
};

constexpr double kStart = 1000.0;  // stamps of 0 mean unset [s]

void PrintTo(const Motor& motor, std::ostream* out) { *out << motor.name; }

class Assembly : public testing::TestWithParam<Motor> {};

ScanLine coreLine(const sim::Scanner& scanner, const sim::ScanLine& from) {
  const sim::Sensor& sensor = scanner.options().sensor;
  ScanLine line;
  line.stamp = kStart + from.stamp;
  line.time_increment = scanner.timeIncrement();
  line.bearing_min = sensor.bearing_min;
  line.bearing_increment = sensor.bearing_increment;
  line.range_min = sensor.range_min;
  line.range_max = sensor.range_max;
  line.ranges = from.ranges;
  return line;
}

Eigen::Vector3d truePoint(const sim::Scanner& scanner, const sim::ScanLine& line, int beam) {
  const sim::Sensor& sensor = scanner.options().sensor;
  const double bearing = sensor.bearing_min + beam * sensor.bearing_increment;
  const double range = line.true_ranges[beam];
  return scanner.truePose(line.true_tilts[beam]) * (range * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0));
}

TEST_P(Assembly, PointsAreTrueWithinAMillimetreAtTenMetres) {
  const Motor& motor = GetParam();
  sim::ScannerOptions options;
  options.motion.kind = motor.kind;
  options.motion.axis = sim::axisFromName(motor.axis);
  options.motion.pass_angle = motor.pass_angle;
  options.motion.lines_per_pass = 120;
  options.mount = sim::mountFrom({0.05, 0.02, 0.08}, motor.rpy);
  const sim::Scanner scanner(sim::makeScene("corridor", 2), options, 2);

  TiltPoseSource poses(options.motion.axis, TiltTrackOptions{});
  poses.setMount(options.mount);
  SweepOptions sweep_options;
  sweep_options.motion = motor.sweeps;
  std::vector<Sweep> sweeps;
  SweepAssembler assembler(sweep_options, poses, [&](Sweep&& sweep) { sweeps.push_back(std::move(sweep)); });
  std::vector<sim::ScanLine> lines;
  sim::ScanStream stream(scanner, 0);
  while (lines.size() < 260) {
    const sim::ScanEvent event = stream.next();
    if (event.is_line) {
      lines.push_back(event.line);
      ASSERT_EQ(assembler.push(coreLine(scanner, event.line)), "");
    } else {
      poses.track().add(kStart + event.joint.stamp, event.joint.angle);
      assembler.process();
    }
  }

  ASSERT_GE(sweeps.size(), motor.sweeps == SweepMotion::kFullTurn ? 1U : 2U);
  for (const Sweep& sweep : sweeps) {
    const BeamGrid grid = toBeamGrid(sweep.image);
    double worst = 0.0;
    int far = 0;
    for (int r = 0; r < grid.rows; ++r) {
      if (r > 0) {
        ASSERT_GE(sweep.image.tilts[r], sweep.image.tilts[r - 1]);
      }
      const int index = static_cast<int>(std::lround((sweep.image.row_stamps[r] - kStart) * options.sensor.line_rate));
      for (int c = 0; c < grid.cols; ++c) {
        const int i = grid.index(r, c);
        if (!grid.valid(i) || grid.range[i] > 10.0F) continue;
        far += grid.range[i] > 5.0F ? 1 : 0;
        const double error = (grid.point(i).cast<double>() - truePoint(scanner, lines[index], c)).norm();
        worst = std::max(worst, error * 10.0 / std::max(1.0F, grid.range[i]));
      }
    }
    EXPECT_LT(worst, 1e-3) << motor.name;
    EXPECT_GT(far, 300) << motor.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Motors, Assembly,
                         testing::Values(Motor{"nodding", sim::Motion::Kind::kNodding, "pitch", Eigen::Vector3d::Zero(),
                                               M_PI, SweepMotion::kNodding},
                                         Motor{"roll", sim::Motion::Kind::kSpinning, "roll", Eigen::Vector3d::Zero(), M_PI,
                                               SweepMotion::kHalfTurn},
                                         Motor{"yaw", sim::Motion::Kind::kSpinning, "yaw", Eigen::Vector3d(M_PI / 2, 0, 0),
                                               2 * M_PI, SweepMotion::kFullTurn}),
                         [](const testing::TestParamInfo<Motor>& tested) { return tested.param.name; });

}  // namespace
}  // namespace ppc
