// SPDX-License-Identifier: BSD-3-Clause
// Any sequence of laser scans and joint samples -> sweeps: accounts close, buffers are bounded, every image is consistent
// and no row has a tilt that the joint did not have.
#include "checks.h"
#include "entry.h"
#include "patch_plane_clustering/core/sweep_assembler.h"
#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <algorithm>
#include <cmath>

namespace ppc::fuzz {
namespace {

constexpr int kMostSteps = 3000;

SweepOptions takeOptions(Input& input) {
  SweepOptions options;
  options.motion = static_cast<SweepMotion>(input.integer(0, 2));
  options.turn_hysteresis = input.real(0.0, 0.1);
  options.poses_per_row = input.integer(1, 5);
  options.min_lines = input.integer(1, 8);
  options.max_lines = input.integer(1, 60);
  options.min_tilt_span = input.real(0.0, 0.1);
  options.max_line_gap = input.real(0.01, 2.0);
  options.standing_lines = input.integer(1, 20);
  options.skip = std::max(0, input.integer(0, 5) - 3);
  options.max_queue = input.integer(1, 20);
  return options;
}

sensor_msgs::LaserScan scanAt(double stamp, int beams) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = toTime(stamp);
  scan.angle_min = -1.0F;
  scan.angle_increment = 2.0F / static_cast<float>(std::max(1, beams - 1));
  scan.angle_max = 1.0F;
  scan.time_increment = 0.001F;
  scan.range_min = 0.1F;
  scan.range_max = 30.0F;
  scan.ranges.assign(static_cast<std::size_t>(beams), 2.0F);
  return scan;
}

void corrupt(Input& input, sensor_msgs::LaserScan& scan) {
  const auto value = input.raw<float>();
  switch (input.integer(0, 8)) {
    case 0:
      scan.angle_min = value;
      break;
    case 1:
      scan.angle_increment = value;
      break;
    case 2:
      scan.time_increment = value;
      break;
    case 3:
      scan.range_min = value;
      break;
    case 4:
      scan.range_max = value;
      break;
    case 5:
      scan.ranges.resize(input.raw<std::uint8_t>());
      break;
    case 6:
      scan.intensities.resize(input.flag() ? scan.ranges.size() : 3, value);
      break;
    case 7:
      scan.header.stamp = ros::Time(input.raw<std::uint32_t>(), input.raw<std::uint32_t>() % 1000000000U);
      break;
    default:
      std::fill(scan.ranges.begin(), scan.ranges.end(), value);
  }
}

class Driver {
 public:
  explicit Driver(Input& input)
      : options_(takeOptions(input)),
        poses_(Eigen::Vector3d::UnitY(), TiltTrackOptions{0.5, 10.0, 64}),
        assembler_(options_, poses_, [this](Sweep&& sweep) { check(sweep); }) {
    if (input.flag()) poses_.setMount(Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.05)));
  }

  void step(Input& input) {
    const std::uint8_t what = input.raw<std::uint8_t>();
    const double dt = input.raw<std::int8_t>() * (what < 128 ? 0.001 : 0.05);
    if (what % 16 == 0) {
      assembler_.close(SweepEnd::kRequest);
    } else if (what % 16 == 1) {
      poses_.setMount(Eigen::Isometry3d::Identity());
    } else if (what % 16 < 9) {
      joint_time_ += dt;
      angle_ += input.raw<std::int8_t>() * 0.002;
      if (what % 16 == 8) angle_ = input.raw<float>();
      addJoint(joint_time_, angle_);
    } else {
      scan_time_ += dt;
      sensor_msgs::LaserScan scan = scanAt(scan_time_, what % 16 == 14 ? input.integer(0, 40) : 9);
      if (what % 16 == 15) corrupt(input, scan);
      pushScan(scan);
    }
    checkAccounts();
  }

  void finish() {
    assembler_.close(SweepEnd::kIdle);
    checkAccounts();
  }

 private:
  void addJoint(double stamp, double angle) {
    poses_.track().add(stamp, angle);
    if (std::isfinite(angle)) {
      const double wrapped = std::remainder(angle, kTurn);
      lowest_ = std::min(lowest_, wrapped);
      highest_ = std::max(highest_, wrapped);
    }
    assembler_.process();
  }

  void pushScan(const sensor_msgs::LaserScan& scan) {
    if (faultOf(scan).empty()) {
      assembler_.push(toScanLine(scan));
    } else {
      assembler_.countDropped(DropCause::kBadScan);
    }
  }

  void checkAccounts() const {
    const LineAccounts& accounts = assembler_.accounts();
    require(accounts.lines_in == accounts.lines_in_images + accounts.pending + accounts.allDrops(), "accounts do not close");
    require(accounts.pending <= static_cast<std::uint64_t>(options_.max_queue + options_.max_lines) + 3, "lines pile up");
  }

  void check(const Sweep& sweep) const {
    const RangeImage& image = sweep.image;
    checkConsistent(image);
    require(image.rows >= options_.min_lines && image.rows <= options_.max_lines, "sweep has too few or too many lines");
    require(std::is_sorted(image.tilts.begin(), image.tilts.end()), "rows are not in ascending tilt");
    require(std::isfinite(sweep.stamp), "stamp is not finite");
    for (const double tilt : image.tilts) {
      require(std::isfinite(tilt), "tilt is not finite");
      // Across +-pi anything lies between the lowest and the highest.
      const double wrapped = std::remainder(tilt, kTurn);
      require(highest_ - lowest_ > 0.5 * kTurn || (wrapped >= lowest_ - 1e-6 && wrapped <= highest_ + 1e-6),
              "a row has tilt " + std::to_string(tilt) + ", the joint was always in " + std::to_string(lowest_) + ".." +
                  std::to_string(highest_));
    }
    checkGrid(toBeamGrid(image));
    require(fromMessage(toMessage(image, std_msgs::Header())).rows == image.rows, "message has other rows");
  }

  static constexpr double kTurn = 6.283185307179586;
  SweepOptions options_;
  TiltPoseSource poses_;
  SweepAssembler assembler_;
  double scan_time_ = 1000.0, joint_time_ = 1000.0, angle_ = 0.0;
  double lowest_ = 1e9, highest_ = -1e9;  // of the joint's angles, in -pi..pi [rad]
};

}  // namespace

void run(Input input) {
  Driver driver(input);
  for (int i = 0; i < kMostSteps && input.remaining() > 0; ++i) driver.step(input);
  driver.finish();
}

}  // namespace ppc::fuzz
