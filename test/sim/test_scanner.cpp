// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/sim/scanner.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <set>

namespace ppc::sim {
namespace {

using Eigen::Vector3d;
constexpr double kDegree = M_PI / 180.0;

ScannerOptions optionsWith(const ErrorModel& errors, int lines = 40) {
  ScannerOptions o;
  o.errors = errors;
  o.motion.lines_per_pass = lines;
  return o;
}

// Largest distance between a measured point and the true one of the same pixel, over points within `range` of the laser [m].
double worstPoint(const Sweep& sweep, double range) {
  const BeamGrid measured = toBeamGrid(sweep.image), truth = toBeamGrid(sweep.truth);
  double worst = 0.0;
  int compared = 0;
  for (int i = 0; i < measured.size(); ++i) {
    if (!measured.valid(i) || measured.range[i] > range) continue;
    worst = std::max(worst, static_cast<double>((measured.point(i) - truth.point(i)).norm()));
    ++compared;
  }
  EXPECT_GT(compared, 1000);
  return worst;
}

// Range errors of all beams that hit a plane, line by line.
std::vector<std::vector<double>> rangeErrors(const Scanner& scanner, int lines) {
  std::vector<std::vector<double>> errors;
  for (int l = 0; l < lines; ++l) {
    const ScanLine line = scanner.line(l);
    errors.emplace_back();
    for (std::size_t b = 0; b < line.ranges.size(); ++b) {
      if (std::isfinite(line.ranges[b])) errors.back().push_back(line.ranges[b] - line.true_ranges[b]);
    }
  }
  return errors;
}

struct Moments {
  double mean = 0, deviation = 0;
  double correlation[6] = {};
};

Moments momentsOf(const std::vector<std::vector<double>>& lines) {
  Moments m;
  double n = 0;
  for (const auto& line : lines) {
    for (const double e : line) {
      m.mean += e;
      n += 1;
    }
  }
  m.mean /= n;
  for (int lag = 0; lag < 6; ++lag) {
    double sum = 0, pairs = 0;
    for (const auto& line : lines) {
      for (std::size_t i = lag; i < line.size(); ++i) {
        sum += (line[i] - m.mean) * (line[i - lag] - m.mean);
        pairs += 1;
      }
    }
    if (lag == 0) m.deviation = std::sqrt(sum / pairs);
    m.correlation[lag] = sum / pairs / (m.deviation * m.deviation);
  }
  return m;
}

TEST(Scanner, WallRangesAreAnalytic) {
  ErrorModel errors = ErrorModel::none();
  errors.motion_in_line = false;
  const Scanner scanner(makeScene("wall", 0), optionsWith(errors), 1);
  for (const int l : {0, 13, 39}) {
    const ScanLine line = scanner.line(l);
    ASSERT_EQ(line.ranges.size(), 1081U);
    const double tilt = scanner.options().motion.tilt(line.stamp, scanner.passDuration());
    for (int b = 0; b < 1081; ++b) {
      const double bearing = (-135.0 + 0.25 * b) * kDegree;
      const double range = 3.0 / (std::cos(bearing) * std::cos(tilt));
      const Vector3d p =
          range * Vector3d(std::cos(bearing) * std::cos(tilt), std::sin(bearing), -std::cos(bearing) * std::sin(tilt));
      if (std::cos(bearing) < 0.1 || std::abs(p.y()) > 9.99 || std::abs(p.z()) > 9.99) continue;
      ASSERT_NEAR(line.ranges[b], range, 1e-5) << "beam " << b;
      ASSERT_EQ(line.labels[b], 1);
    }
    EXPECT_TRUE(std::isinf(line.ranges[0]));  // looks back
    EXPECT_EQ(line.labels[0], 0);
  }
}

TEST(Scanner, PositiveTiltIsNoseDown) {
  const Scanner scanner(makeScene("wall", 0), optionsWith(ErrorModel::none()), 1);
  const Vector3d ahead = scanner.nominalPose(0.5) * Vector3d::UnitX();
  EXPECT_NEAR(ahead.x(), std::cos(0.5), 1e-12);
  EXPECT_NEAR(ahead.z(), -std::sin(0.5), 1e-12);
}

TEST(Scanner, WithoutErrorsSweepsAreExactHoweverTheMotorMoves) {
  const double quarter = 0.5 * M_PI;
  struct Case {
    Motion::Kind kind;
    std::string axis;
    Vector3d rpy;
    double pass_angle;
  };
  for (const Case& c : {Case{Motion::Kind::kNodding, "pitch", Vector3d::Zero(), M_PI},
                        Case{Motion::Kind::kNodding, "roll", Vector3d::Zero(), M_PI},
                        Case{Motion::Kind::kSpinning, "roll", Vector3d::Zero(), M_PI},
                        Case{Motion::Kind::kSpinning, "yaw", Vector3d(quarter, 0, 0), 2 * M_PI}}) {
    ScannerOptions o = optionsWith(ErrorModel::none(), 200);
    o.motion.kind = c.kind;
    o.motion.axis = axisFromName(c.axis);
    o.motion.pass_angle = c.pass_angle;
    o.mount = mountFrom({0.05, 0.02, 0.08}, c.rpy);
    const Scanner scanner(makeScene("box", 0), o, 1);
    for (const int pass : {0, 1}) {
      const Sweep sweep = scanner.sweep(pass);
      EXPECT_LT(worstPoint(sweep, 10.0), 1e-3) << c.axis << " pass " << pass;
      EXPECT_TRUE(std::is_sorted(sweep.image.tilts.begin(), sweep.image.tilts.end()));
      const BeamGrid grid = toBeamGrid(sweep.truth);
      for (int i = 0; i < grid.size(); i += 37) {
        const Plane plane = scanner.scene().planeInBase(sweep.labels.labels[i]);
        ASSERT_NEAR(plane.signedDistance(grid.point(i).cast<double>()), 0.0, 1e-3) << c.axis << " pixel " << i;
      }
    }
  }
}

TEST(Scanner, MotionWithinALineMovesItsBeams) {
  const Scanner moving(makeScene("box", 0), optionsWith(ErrorModel::none()), 1);
  const ScanLine line = moving.line(20);
  EXPECT_NEAR(moving.timeIncrement(), 0.025 * 0.25 / 360.0, 1e-12);
  EXPECT_GT(line.true_tilts.back() - line.true_tilts.front(), 1.0 * kDegree);
  ErrorModel still = ErrorModel::none();
  still.motion_in_line = false;
  const Scanner frozen(makeScene("box", 0), optionsWith(still), 1);
  EXPECT_EQ(frozen.timeIncrement(), 0.0);
  EXPECT_EQ(frozen.line(20).true_tilts.back(), line.true_tilts.front());
}

TEST(Scanner, LinesDoNotDependOnTheOrderOfAsking) {
  const ScannerOptions o = optionsWith(ErrorModel::realistic(1.0));
  const Scanner a(makeScene("office", 3), o, 3), b(makeScene("office", 3), o, 3), other(makeScene("office", 3), o, 4);
  const ScanLine late = a.line(30), early = a.line(5);
  const ScanLine again_early = b.line(5), again_late = b.line(30);
  const auto same = [](const ScanLine& x, const ScanLine& y) {
    // Bytes, for NaN is not equal to itself.
    return std::memcmp(x.ranges.data(), y.ranges.data(), x.ranges.size() * sizeof(float)) == 0 && x.labels == y.labels;
  };
  EXPECT_TRUE(same(late, again_late));
  EXPECT_TRUE(same(early, again_early));
  EXPECT_FALSE(same(late, early));
  EXPECT_FALSE(same(late, other.line(30)));
  EXPECT_EQ(a.joint(17).angle, b.joint(17).angle);
  EXPECT_NE(a.joint(17).angle, other.joint(17).angle);
}

TEST(Scanner, WhiteNoiseFollowsTheDataSheet) {
  for (const double scale : {1.0, 2.0, 4.0}) {
    ErrorModel errors = ErrorModel::none();
    errors.noise_scale = scale;
    const Moments m = momentsOf(rangeErrors(Scanner(makeScene("box", 0), optionsWith(errors), 2), 40));
    EXPECT_NEAR(m.deviation, scale * 0.010, scale * 0.0002);
    EXPECT_NEAR(m.mean, 0.0, scale * 0.0002);
    for (int lag = 1; lag < 6; ++lag) EXPECT_NEAR(m.correlation[lag], 0.0, 0.02) << "lag " << lag;
  }
}

TEST(Scanner, CorrelatedNoiseHasTheMeasuredLags) {
  ErrorModel errors = ErrorModel::none();
  errors.noise_scale = 1.0;
  errors.correlated_noise = true;
  const Moments m = momentsOf(rangeErrors(Scanner(makeScene("box", 0), optionsWith(errors), 2), 40));
  EXPECT_NEAR(m.deviation, 0.010, 0.0003);
  const double expected[6] = {1.0, 0.7, 0.5, 0.3, 0.1, 0.0};
  for (int lag = 1; lag < 6; ++lag) EXPECT_NEAR(m.correlation[lag], expected[lag], 0.03) << "lag " << lag;
}

TEST(Scanner, UrgNoiseGrowsWithRange) {
  ScannerOptions o = optionsWith(ErrorModel::none());
  o.sensor = makeSensor("urg_04lx");
  o.errors.noise_scale = 1.0;
  const Scanner scanner(makeScene("box", 0), o, 1);
  double squares = 0, count = 0;
  for (int l = 0; l < 40; ++l) {
    const ScanLine line = scanner.line(l);
    for (std::size_t b = 0; b < line.ranges.size(); ++b) {
      if (!std::isfinite(line.ranges[b])) continue;
      const double z = (line.ranges[b] - line.true_ranges[b]) / std::max(0.01, 0.01 * line.true_ranges[b]);
      squares += z * z;
      count += 1;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 0.02);
}

TEST(Scanner, RangesStandOnTheGrid) {
  ErrorModel errors = ErrorModel::none();
  errors.noise_scale = 1.0;
  errors.range_grid = 0.01;
  const ScanLine line = Scanner(makeScene("box", 0), optionsWith(errors), 1).line(10);
  std::set<long> steps;
  for (const float r : line.ranges) {
    const double step = r / 0.01;
    ASSERT_NEAR(step, std::round(step), 1e-4);
    steps.insert(std::lround(step));
  }
  EXPECT_GT(steps.size(), 50U);
}

TEST(Scanner, DropoutsAreNaNAndUnlabelled) {
  ErrorModel errors = ErrorModel::none();
  errors.dropouts = 0.1;
  const Scanner scanner(makeScene("box", 0), optionsWith(errors), 1);
  int dropped = 0, beams = 0;
  for (int l = 0; l < 40; ++l) {
    const ScanLine line = scanner.line(l);
    for (std::size_t b = 0; b < line.ranges.size(); ++b, ++beams) {
      ASSERT_EQ(std::isnan(line.ranges[b]), line.labels[b] == 0);
      dropped += std::isnan(line.ranges[b]) ? 1 : 0;
    }
  }
  EXPECT_NEAR(static_cast<double>(dropped) / beams, 0.1, 0.005);
}

TEST(Scanner, ReadingsOutOfRangeFollowRep117) {
  const ScanLine nothing = Scanner(makeScene("empty", 0), optionsWith(ErrorModel::realistic(1.0)), 1).line(0);
  int infinite = 0;
  for (const float r : nothing.ranges) infinite += r == std::numeric_limits<float>::infinity() ? 1 : 0;
  EXPECT_GT(infinite, 1060);  // the rest are dropouts
  ScannerOptions close = optionsWith(ErrorModel::none());
  close.sensor.range_min = 2.5;
  close.sensor.range_max = 2.9;
  const ScanLine line = Scanner(makeScene("box", 0), close, 1).line(20);
  for (std::size_t b = 0; b < line.ranges.size(); ++b) {
    if (line.true_ranges[b] < 2.5F) {
      ASSERT_EQ(line.ranges[b], -std::numeric_limits<float>::infinity());
    }
    if (line.true_ranges[b] > 2.9F) {
      ASSERT_EQ(line.ranges[b], std::numeric_limits<float>::infinity());
    }
    ASSERT_EQ(std::isfinite(line.ranges[b]), line.labels[b] != 0);
  }
}

TEST(Scanner, MixedPixelsLieBetweenTheSurfacesOfAnEdge) {
  ErrorModel errors = ErrorModel::none();
  errors.mixed_pixels = 1.0;
  const Scanner scanner(makeScene("hole", 0), optionsWith(errors, 300), 1);
  int mixed = 0, unlabelled = 0;
  for (int l = 130; l < 170; ++l) {
    const ScanLine line = scanner.line(l);
    for (int b = 400; b < 680; ++b) {
      if (line.ranges[b] == line.true_ranges[b]) continue;
      ++mixed;
      // Front wall at x = 2, the one behind at x = 3.
      const double slope = line.true_ranges[b] / (line.labels[b] == 2 || line.true_ranges[b] > 2.9 ? 3.0 : 2.0);
      ASSERT_GT(line.ranges[b] / slope, 2.0 - 0.03);
      ASSERT_LT(line.ranges[b] / slope, 3.0 + 0.03);
      if (line.labels[b] == 0) ++unlabelled;
      if (line.labels[b] != 0) {
        ASSERT_NEAR(line.ranges[b], line.true_ranges[b], 0.0301);
      }
    }
  }
  EXPECT_GT(mixed, 20);
  EXPECT_GT(unlabelled, mixed / 2);
  EXPECT_LT(mixed, 40 * 280 / 10);
}

TEST(Scanner, BiasGrowsWithIncidence) {
  ErrorModel errors = ErrorModel::none();
  errors.incidence_bias = 0.01;
  const Scanner scanner(makeScene("wall", 0), optionsWith(errors), 1);
  const ScanLine line = scanner.line(20);
  for (const int b : {540, 600, 700, 800}) {
    const double cosine = 3.0 / line.true_ranges[b];
    EXPECT_NEAR(line.ranges[b] - line.true_ranges[b], 0.01 * (1.0 - cosine), 1e-6) << "beam " << b;
  }
}

TEST(Scanner, TiltErrorsShowInTheJointOnly) {
  ErrorModel errors = ErrorModel::none();
  errors.tilt_offset = 0.2 * kDegree;
  errors.tilt_backlash = 0.1 * kDegree;
  const Scanner scanner(makeScene("wall", 0), optionsWith(errors, 300), 1);
  const auto error = [&](double t) {
    return scanner.reportedTilt(t) - scanner.options().motion.tilt(t, scanner.passDuration());
  };
  EXPECT_NEAR(error(3.0), 0.25 * kDegree, 1e-6);
  EXPECT_NEAR(error(7.5 + 3.0), 0.15 * kDegree, 1e-6);
  EXPECT_EQ(scanner.line(100).ranges,
            Scanner(makeScene("wall", 0), optionsWith(ErrorModel::none(), 300), 1).line(100).ranges);
}

TEST(Scanner, EncoderNoiseIsAsAsked) {
  ErrorModel errors = ErrorModel::none();
  errors.encoder_noise = 1e-3;
  const Scanner scanner(makeScene("wall", 0), optionsWith(errors, 300), 1);
  double squares = 0;
  for (int i = 0; i < 2000; ++i) {
    const JointSample s = scanner.joint(i);
    EXPECT_DOUBLE_EQ(s.stamp, i / 100.0);
    const double e = s.angle - scanner.options().motion.tilt(s.stamp, scanner.passDuration());
    squares += e * e;
  }
  EXPECT_NEAR(std::sqrt(squares / 2000), 1e-3, 5e-5);
}

TEST(Scanner, TiltsOnAGridComeInGroups) {
  ErrorModel errors = ErrorModel::none();
  errors.tilt_grid = 1.0 * kDegree;
  const Scanner scanner(makeScene("wall", 0), optionsWith(errors, 300), 1);
  std::set<double> seen;
  for (int i = 100; i < 600; ++i) {
    const JointSample s = scanner.joint(i);
    const double e = s.angle - scanner.options().motion.tilt(s.stamp, scanner.passDuration());
    EXPECT_LE(std::abs(e), 0.5 * kDegree + 1e-9);
    EXPECT_NEAR(std::remainder(s.angle, kDegree), 0.0, 1e-9);
    seen.insert(std::round(s.angle / kDegree));
  }
  EXPECT_GT(seen.size(), 50U);
  EXPECT_LT(seen.size(), 110U);
}

TEST(Scanner, LineErrorIsSharedByTheBeamsOfALine) {
  ErrorModel errors = ErrorModel::none();
  errors.line_error = 0.01;
  const Scanner scanner(makeScene("box", 0), optionsWith(errors), 1);
  double squares = 0.0;
  for (const std::vector<double>& line : rangeErrors(scanner, 400)) {
    ASSERT_GT(line.size(), 1000U);
    for (const double e : line) EXPECT_NEAR(e, line[0], 1e-5);
    squares += line[0] * line[0];
  }
  EXPECT_NEAR(std::sqrt(squares / 400), 0.01, 0.0015);
}

TEST(Scanner, LeverArmErrorMovesTheLaserNotItsReport) {
  ErrorModel errors = ErrorModel::none();
  errors.lever_arm_error = 0.005;
  ScannerOptions o = optionsWith(errors);
  o.mount = mountFrom({0.0, 0.0, 0.08}, Vector3d::Zero());
  const Scanner scanner(makeScene("wall", 0), o, 1);
  EXPECT_TRUE(scanner.nominalPose(0.0).translation().isApprox(Vector3d(0, 0, 0.08), 1e-12));
  EXPECT_NEAR((scanner.truePose(0.3).translation() - scanner.nominalPose(0.3).translation()).norm(), 0.005, 1e-12);
}

TEST(Scanner, RealisticIsHarderThanTheDataSheetAndBowsTheWalls) {
  const auto bias = [](const ErrorModel& errors) {
    // Distance of the measured points from their true planes, averaged over each plane: white noise cancels, the rest stays.
    ScannerOptions o = optionsWith(errors, 100);
    const Scanner scanner(makeScene("box", 0), o, 1);
    const Sweep sweep = scanner.sweep(0);
    const BeamGrid grid = toBeamGrid(sweep.image);
    double sum[7] = {}, count[7] = {};
    for (int i = 0; i < grid.size(); ++i) {
      const int id = sweep.labels.labels[i];
      if (id == 0) continue;
      sum[id] += scanner.scene().planeInBase(id).signedDistance(grid.point(i).cast<double>());
      count[id] += 1;
    }
    double worst = 0;
    for (int id = 1; id <= 6; ++id) worst = std::max(worst, std::abs(sum[id] / count[id]));
    return worst;
  };
  EXPECT_LT(bias(ErrorModel::dataSheet(1.0)), 0.001);
  EXPECT_GT(bias(ErrorModel::realistic(1.0)), 0.004);
  EXPECT_LT(bias(ErrorModel::realistic(1.0)), 0.03);
  ErrorModel bow = ErrorModel::none();
  bow.wall_bow = 0.005;
  EXPECT_NEAR(bias(bow), 0.005 * 4.0 / (M_PI * M_PI), 0.002);  // mean of the hump, weighted by the scan's density
}

TEST(Scanner, SweepKeepsLabelsAndTruthInStepWithTheImage) {
  const Scanner scanner(makeScene("office", 1), optionsWith(ErrorModel::dataSheet(1.0), 30), 1);
  const Sweep down = scanner.sweep(1);
  ASSERT_EQ(down.image.rows, 30);
  ASSERT_EQ(down.labels.labels.size(), 30U * 1081U);
  // The second pass runs backwards: the first row is the last line.
  const ScanLine last = scanner.line(59);
  EXPECT_EQ(down.image.row_stamps.front(), last.stamp);
  for (int c = 0; c < 1081; ++c) {
    EXPECT_EQ(down.labels.labels[c], last.labels[c]);
    EXPECT_EQ(down.truth.ranges[c], last.true_ranges[c]);
  }
  EXPECT_NO_THROW(checkConsistent(down.image));
  EXPECT_NO_THROW(checkConsistent(down.truth));
}

TEST(Scanner, OptionsAreChecked) {
  const auto refuses = [](const std::function<void(ScannerOptions&)>& change, const std::string& name) {
    ScannerOptions o;
    change(o);
    try {
      Scanner(makeScene("box", 0), o, 1);
      ADD_FAILURE() << name << " accepted";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
    }
  };
  refuses([](ScannerOptions& o) { o.motion.lines_per_pass = 0; }, "lines_per_pass");
  refuses([](ScannerOptions& o) { o.motion.turn_share = 0.6; }, "turn_share");
  refuses([](ScannerOptions& o) { o.errors.dropouts = 1.5; }, "dropouts");
  refuses([](ScannerOptions& o) { o.errors.noise_scale = -1.0; }, "noise_scale");
  refuses([](ScannerOptions& o) { o.joint_rate = std::nan(""); }, "joint_rate");
  const Scanner scanner(makeScene("box", 0), {}, 1);
  EXPECT_THROW(scanner.line(-1), std::invalid_argument);
  EXPECT_THROW(scanner.sweep(-1), std::invalid_argument);
  EXPECT_THROW(makeSensor("sick"), std::invalid_argument);
}

TEST(ErrorModel, FieldsAreSetByName) {
  ErrorModel errors;
  for (const ErrorField& field : errorFields()) {
    setErrorField(errors, field.name, 0.5 * field.max);
    EXPECT_DOUBLE_EQ(errors.*field.value, 0.5 * field.max);
    EXPECT_THROW(setErrorField(errors, field.name, 1.1 * field.max), std::invalid_argument) << field.name;
    EXPECT_THROW(setErrorField(errors, field.name, std::nan("")), std::invalid_argument) << field.name;
  }
  setErrorField(errors, "correlated_noise", 1.0);
  setErrorField(errors, "motion_in_line", 0.0);
  EXPECT_TRUE(errors.correlated_noise);
  EXPECT_FALSE(errors.motion_in_line);
  EXPECT_THROW(setErrorField(errors, "gremlins", 1.0), std::invalid_argument);
}

TEST(Sensor, PresetsAreTheDataSheets) {
  const Sensor utm = makeSensor("utm_30lx"), urg = makeSensor("urg_04lx"), lms = makeSensor("lms_200");
  EXPECT_EQ(lms.beams, 361);
  EXPECT_NEAR(lms.bearing_min + 360 * lms.bearing_increment, 90.0 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(lms.noise.sigma(5.0), 0.005);
  EXPECT_EQ(utm.beams, 1081);
  EXPECT_NEAR(utm.bearing_min + 1080 * utm.bearing_increment, 135.0 * kDegree, 1e-12);
  EXPECT_NEAR(utm.timeIncrement() * 1440, 1.0 / 40.0, 1e-12);
  EXPECT_DOUBLE_EQ(utm.noise.sigma(5.0), 0.01);
  EXPECT_DOUBLE_EQ(utm.noise.sigma(15.0), 0.03);
  EXPECT_EQ(urg.beams, 682);
  EXPECT_NEAR(urg.bearing_increment, 0.3516 * kDegree, 1e-5);
  EXPECT_DOUBLE_EQ(urg.noise.sigma(0.5), 0.01);
  EXPECT_DOUBLE_EQ(urg.noise.sigma(4.0), 0.04);
}

}  // namespace
}  // namespace ppc::sim
