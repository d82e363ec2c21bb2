// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/sim/scanner.h"

#include "patch_plane_clustering/sim/random.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace ppc::sim {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
// Streams of random numbers: lines take their index, joint samples theirs from here on.
constexpr std::uint64_t kJointStream = 1ULL << 32;
constexpr std::uint64_t kLineErrorStream = 1ULL << 33;
// A spot that touches surfaces at least this far apart in range reads something between.
constexpr double kMixedGap = 0.05;

void requireRange(const std::string& name, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw std::invalid_argument(name + " is " + std::to_string(value) + ", allowed: " + std::to_string(low) + " to " +
                                std::to_string(high));
  }
}

void check(const ScannerOptions& o) {
  requireRange("beams", o.sensor.beams, 1, 100000);
  requireRange("line_rate", o.sensor.line_rate, 1e-3, 1e4);
  requireRange("lines_per_pass", o.motion.lines_per_pass, 1, 100000);
  requireRange("amplitude", o.motion.amplitude, 0.0, M_PI);
  requireRange("turn_share", o.motion.turn_share, 0.0, 0.5);
  requireRange("axis length", o.motion.axis.norm(), 1.0 - 1e-6, 1.0 + 1e-6);
  requireRange("joint_rate", o.joint_rate, 0.1, 1e5);
  requireRange("poses_per_row", o.poses_per_row, 1, 10000);
  checkErrors(o.errors);
}

// Unit-variance noise along a line.
std::vector<double> lineNoise(int beams, bool correlated, Random& random) {
  std::vector<double> noise(beams);
  if (!correlated) {
    for (double& n : noise) n = random.normal();
    return noise;
  }
  std::vector<double> white(beams + kNoiseFilter.size() - 1);
  for (double& w : white) w = random.normal();
  for (int b = 0; b < beams; ++b) {
    noise[b] = std::inner_product(kNoiseFilter.begin(), kNoiseFilter.end(), white.begin() + b, 0.0);
  }
  return noise;
}

}  // namespace

Eigen::Isometry3d mountFrom(const Eigen::Vector3d& lever_arm, const Eigen::Vector3d& rpy) {
  return Eigen::Translation3d(lever_arm) * Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
         Eigen::Isometry3d(Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
}

Scanner::Scanner(Scene scene, ScannerOptions options, std::uint64_t seed)
    : scene_(std::move(scene)), options_(std::move(options)), seed_(seed), true_mount_(options_.mount) {
  check(options_);
  if (options_.errors.wall_bow > 0.0) scene_.bowWalls(options_.errors.wall_bow);
  scene_.build();
  true_mount_.translation() += options_.errors.lever_arm_error * Eigen::Vector3d(0.6, 0.0, 0.8);
}

double Scanner::timeIncrement() const { return options_.errors.motion_in_line ? options_.sensor.timeIncrement() : 0.0; }

Eigen::Isometry3d Scanner::nominalPose(double tilt) const {
  return Eigen::Isometry3d(Eigen::AngleAxisd(tilt, options_.motion.axis)) * options_.mount;
}

Eigen::Isometry3d Scanner::truePose(double tilt) const {
  return Eigen::Isometry3d(Eigen::AngleAxisd(tilt, options_.motion.axis)) * true_mount_;
}

Hit Scanner::castBeam(const Eigen::Isometry3d& pose, double bearing, double across, double up) const {
  const double c = std::cos(bearing), s = std::sin(bearing);
  const Eigen::Vector3d d = Eigen::Vector3d(c - across * s, s + across * c, up).normalized();
  const Eigen::Isometry3d laser = scene_.tilt_base * pose;
  return scene_.cast(laser.translation(), laser.linear() * d);
}

ScanLine Scanner::line(int index) const {
  if (index < 0) throw std::invalid_argument("line index is " + std::to_string(index) + ", allowed: from 0");
  const Sensor& sensor = options_.sensor;
  const ErrorModel& errors = options_.errors;
  Random random(seed_, static_cast<std::uint64_t>(index));
  ScanLine line;
  line.index = index;
  line.stamp = index * lineDuration();
  line.ranges.resize(sensor.beams);
  line.true_ranges.resize(sensor.beams);
  line.true_tilts.resize(sensor.beams);
  line.labels.assign(sensor.beams, 0);
  const std::vector<double> noise = lineNoise(sensor.beams, errors.correlated_noise, random);
  const double shared =
      errors.line_error > 0.0
          ? errors.line_error * Random(seed_, kLineErrorStream + static_cast<std::uint64_t>(index)).normal()
          : 0.0;
  Eigen::Isometry3d pose;
  for (int b = 0; b < sensor.beams; ++b) {
    const double bearing = sensor.bearing_min + b * sensor.bearing_increment;
    if (b == 0 || timeIncrement() > 0.0) {
      line.true_tilts[b] = options_.motion.tilt(line.stamp + b * timeIncrement(), passDuration());
      pose = truePose(line.true_tilts[b]);
    } else {
      line.true_tilts[b] = line.true_tilts[0];
    }
    const Hit hit = castBeam(pose, bearing, 0.0, 0.0);
    line.true_ranges[b] = static_cast<float>(hit.range);

    // Each beam draws the same numbers whatever the switches, so that switching one source leaves the others as they were.
    const double spot = 0.5 * sensor.spot_angle * std::sqrt(random.uniform());
    const double spot_side = 2.0 * M_PI * random.uniform();
    const double mixing = random.uniform();
    const bool mixes = random.chance(errors.mixed_pixels);
    const bool drops = random.chance(errors.dropouts);
    double range = hit.range + shared + errors.incidence_bias * (1.0 - hit.cos_incidence);
    bool on_surface = true;
    if (mixes && std::isfinite(hit.range)) {
      const Hit other = castBeam(pose, bearing, spot * std::cos(spot_side), spot * std::sin(spot_side));
      const double gap = other.range - hit.range;
      const bool same_plane = other.plane_id == hit.plane_id && hit.plane_id != 0;
      if (std::isfinite(gap) && std::abs(gap) > kMixedGap && !same_plane) {
        range += mixing * gap;
        on_surface = mixing * std::abs(gap) <= 3.0 * sensor.noise.sigma(hit.range);
      }
    }
    if (std::isfinite(range)) range += errors.noise_scale * sensor.noise.sigma(range) * noise[b];
    if (errors.range_grid > 0.0) range = std::round(range / errors.range_grid) * errors.range_grid;
    if (drops) {
      line.ranges[b] = std::numeric_limits<float>::quiet_NaN();
    } else if (range < sensor.range_min) {
      line.ranges[b] = -kInf;
    } else {
      line.ranges[b] = range > sensor.range_max ? kInf : static_cast<float>(range);
    }
    if (std::isfinite(line.ranges[b]) && on_surface) line.labels[b] = hit.plane_id;
  }
  return line;
}

JointSample Scanner::joint(int index) const {
  if (index < 0) throw std::invalid_argument("joint sample index is " + std::to_string(index) + ", allowed: from 0");
  const ErrorModel& errors = options_.errors;
  JointSample sample;
  sample.stamp = index / options_.joint_rate;
  const double backlash =
      0.5 * errors.tilt_backlash * (options_.motion.ascending(sample.stamp, passDuration()) ? 1.0 : -1.0);
  sample.angle = options_.motion.tilt(sample.stamp, passDuration()) + errors.tilt_offset + backlash;
  if (errors.encoder_noise > 0.0) {
    sample.angle += errors.encoder_noise * Random(seed_, kJointStream + static_cast<std::uint64_t>(index)).normal();
  }
  if (errors.tilt_grid > 0.0) sample.angle = std::round(sample.angle / errors.tilt_grid) * errors.tilt_grid;
  return sample;
}

double Scanner::reportedTilt(double t) const {
  requireRange("time", t, 0.0, 1e9);
  const int before = static_cast<int>(t * options_.joint_rate);
  const JointSample a = joint(before), b = joint(before + 1);
  return a.angle + (b.angle - a.angle) * (t - a.stamp) / (b.stamp - a.stamp);
}

Sweep Scanner::sweep(int pass) const {
  if (pass < 0) throw std::invalid_argument("pass is " + std::to_string(pass) + ", allowed: from 0");
  const Sensor& sensor = options_.sensor;
  const int rows = options_.motion.lines_per_pass, cols = sensor.beams;
  std::vector<ScanLine> lines;
  std::vector<double> tilts;
  for (int i = 0; i < rows; ++i) {
    lines.push_back(line(pass * rows + i));
    tilts.push_back(reportedTilt(lines.back().stamp + 0.5 * (cols - 1) * timeIncrement()));
  }
  std::vector<int> order(rows);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return tilts[a] < tilts[b]; });

  Sweep sweep;
  RangeImage& image = sweep.image;
  image.rows = sweep.labels.rows = rows;
  image.cols = sweep.labels.cols = cols;
  image.bearing_min = sensor.bearing_min;
  image.bearing_increment = sensor.bearing_increment;
  image.range_min = sensor.range_min;
  image.range_max = sensor.range_max;
  image.poses_per_row = options_.poses_per_row;
  sweep.truth = image;
  sweep.truth.range_min = 0.0;
  sweep.truth.range_max = std::numeric_limits<double>::max();
  for (const int i : order) {
    const ScanLine& line = lines[i];
    image.ranges.insert(image.ranges.end(), line.ranges.begin(), line.ranges.end());
    sweep.truth.ranges.insert(sweep.truth.ranges.end(), line.true_ranges.begin(), line.true_ranges.end());
    sweep.labels.labels.insert(sweep.labels.labels.end(), line.labels.begin(), line.labels.end());
    image.tilts.push_back(tilts[i]);
    sweep.truth.tilts.push_back(line.true_tilts[cols / 2]);
    image.row_stamps.push_back(line.stamp);
    for (int k = 0; k < image.poses_per_row; ++k) {
      // One pose a row stands at its middle, several run from the first beam to the last.
      const double beam = image.poses_per_row == 1 ? 0.5 * (cols - 1) : k * (cols - 1.0) / (image.poses_per_row - 1);
      const double t = line.stamp + beam * timeIncrement();
      image.line_poses.push_back(nominalPose(reportedTilt(t)));
      sweep.truth.line_poses.push_back(truePose(options_.motion.tilt(t, passDuration())));
    }
  }
  sweep.truth.row_stamps = image.row_stamps;
  return sweep;
}

Sweep simulateSweep(const std::string& scene, const std::string& sensor, const ErrorModel& errors, std::uint64_t seed,
                    int lines) {
  ScannerOptions options;
  options.sensor = makeSensor(sensor);
  options.motion.lines_per_pass = lines;
  options.errors = errors;
  return Scanner(makeScene(scene, seed), options, seed).sweep(0);
}

}  // namespace ppc::sim
