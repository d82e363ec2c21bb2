// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/scan_stream.h"

#include <gtest/gtest.h>

namespace ppc::sim {
namespace {

Scanner smallScanner() {
  ScannerOptions o;
  o.motion.lines_per_pass = 4;
  o.sensor.beams = 20;
  o.errors.noise_scale = 1.0;
  return Scanner(makeScene("box", 0), o, 1);
}

TEST(ScanStream, EventsComeInOrderAndNoneIsMissing) {
  const Scanner scanner = smallScanner();
  ScanStream stream(scanner, 0);
  double previous = -1.0;
  int lines = 0, joints = 0;
  while (lines < 40) {
    const double announced = stream.nextTime();
    const ScanEvent event = stream.next();
    EXPECT_EQ(event.time, announced);
    EXPECT_GE(event.time, previous);
    previous = event.time;
    if (event.is_line) {
      EXPECT_EQ(event.line.index, lines);
      EXPECT_DOUBLE_EQ(event.line.stamp, lines * 0.025);
      EXPECT_GT(event.time, event.line.stamp);
      EXPECT_EQ(event.line.ranges, scanner.line(lines).ranges);
      ++lines;
    } else {
      EXPECT_DOUBLE_EQ(event.joint.stamp, joints / 100.0);
      ++joints;
    }
  }
  EXPECT_NEAR(joints, 98, 1);  // 100 Hz until the last line's end
}

TEST(ScanStream, ReplayRepeatsLinesWithLaterStamps) {
  const Scanner scanner = smallScanner();
  ScanStream stream(scanner, 2);
  int lines = 0;
  while (lines < 20) {
    const ScanEvent event = stream.next();
    if (!event.is_line) continue;
    EXPECT_EQ(event.line.ranges, scanner.line(lines % 8).ranges) << "line " << lines;
    EXPECT_EQ(event.line.index, lines);
    EXPECT_DOUBLE_EQ(event.line.stamp, lines * 0.025);
    ++lines;
  }
}

TEST(ScanStream, ReplayNeedsWholePeriods) {
  const Scanner scanner = smallScanner();
  EXPECT_THROW(ScanStream(scanner, 3), std::invalid_argument);
  EXPECT_THROW(ScanStream(scanner, -2), std::invalid_argument);
}

}  // namespace
}  // namespace ppc::sim
