// SPDX-License-Identifier: BSD-3-Clause
#include "bag_sweeps.h"

#include "bag_check.h"
#include "bag_message.h"
#include "bag_tilt.h"
#include "files.h"
#include "number_check.h"
#include "patch_plane_clustering/core/tilt_pose_source.h"
#include "patch_plane_clustering/ros/joint_sample.h"
#include "patch_plane_clustering/ros/publisher_watch.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <stdexcept>

namespace ppc {
namespace {

SweepMotion motionNamed(const std::string& name) {
  return name == "nodding" ? SweepMotion::kNodding : name == "half_turn" ? SweepMotion::kHalfTurn : SweepMotion::kFullTurn;
}

// The first of its kind, to be told once.
struct FirstFaults {
  std::string scan, joint;
};

void note(std::string& first, const std::string& fault) {
  if (first.empty()) first = fault;
}

// A bag does not tell how many publishers there were at a time.
std::string otherPublisher(PublisherWatch& watch, const rosbag::MessageInstance& message) {
  const std::string fault = watch.faultOf(message.getCallerId(), message.getTime().toSec(), 2);
  return fault.empty() ? fault : message.getTopic() + " is " + fault;
}

// "3 bad scan (stamp is not set (0)), 20 no tilt (joint sample without stamp)"; empty if no line was lost without reason.
std::string lossesOf(const LineAccounts& accounts, const FirstFaults& faults) {
  std::string losses;
  const auto add = [&](std::uint64_t lines, const std::string& what, const std::string& fault) {
    if (lines == 0) return;
    losses += (losses.empty() ? "" : ", ") + std::to_string(lines) + " " + what + (fault.empty() ? "" : " (" + fault + ")");
  };
  for (std::size_t i = 0; i < kDropCauses; ++i) {
    const auto cause = static_cast<DropCause>(i);
    const bool of_joint = cause == DropCause::kNoTilt || cause == DropCause::kTiltGap;
    add(accounts.dropped[i], dropCauseName(cause),
        cause == DropCause::kBadScan ? faults.scan
        : of_joint                   ? faults.joint
                                     : "");
  }
  add(accounts.pending, "without tilt to the end", faults.joint);
  return losses;
}

LineAccounts assemble(const rosbag::Bag& bag, const BagTilt& tilt, const BagOptions& options,
                      const std::function<void(const rosbag::MessageInstance&)>& on_message,
                      const std::function<void(BagSweep&&)>& on_sweep, const std::function<void(double)>& on_progress,
                      FirstFaults& faults) {
  TiltPoseSource poses(tiltAxis(options.axis), TiltTrackOptions{});
  poses.setMount(tilt.mount);
  SweepOptions sweep_options = options.sweep;
  sweep_options.motion = motionNamed(options.motion);
  ros::Time now;
  SweepAssembler assembler(sweep_options, poses, [&](Sweep&& sweep) { on_sweep({std::move(sweep), tilt.base_frame, now}); });
  PublisherWatch scan_publishers, joint_publishers;

  const auto onJoint = [&](const rosbag::MessageInstance& message) {
    const auto joints = messageOf<sensor_msgs::JointState>(message);
    if (!joints) return;
    JointSample sample = readJointSample(*joints, tilt.joint);
    if (!sample.present) return;
    if (sample.fault.empty()) sample.fault = otherPublisher(joint_publishers, message);
    if (!sample.fault.empty()) return note(faults.joint, sample.fault);
    poses.track().add(sample.stamp, sample.angle);
    assembler.process();
  };

  auto next_tilt = tilt.tilts.begin();
  const auto onScan = [&](const rosbag::MessageInstance& message) {
    const auto scan = messageOf<sensor_msgs::LaserScan>(message);
    if (!scan) return;
    ScanLine line = toScanLine(*scan, options.time_offset);
    // All of /tf was read beforehand: samples up to the end of the line, and one that brackets it.
    for (bool bracketed = false; next_tilt != tilt.tilts.end() && !bracketed; ++next_tilt) {
      bracketed = next_tilt->first > line.lastStamp();
      poses.track().add(next_tilt->first, next_tilt->second);
    }
    std::string fault = otherPublisher(scan_publishers, message);
    if (fault.empty()) fault = faultOf(*scan, tilt.laser_frame);
    if (!fault.empty()) {
      assembler.countDropped(DropCause::kBadScan);
    } else {
      fault = assembler.push(std::move(line));
    }
    if (!fault.empty()) note(faults.scan, fault);
  };

  rosbag::View view(bag);
  const double messages = view.size();
  double read = 0.0;
  for (const rosbag::MessageInstance& message : view) {
    now = message.getTime();
    if (on_message) on_message(message);
    if (message.getTopic() == tilt.joint_states) onJoint(message);
    if (message.getTopic() == tilt.scan) onScan(message);
    if (on_progress) on_progress(++read / messages);
  }
  for (; next_tilt != tilt.tilts.end(); ++next_tilt) poses.track().add(next_tilt->first, next_tilt->second);
  assembler.process();
  assembler.close(SweepEnd::kIdle);
  return assembler.accounts();
}

}  // namespace

void BagOptions::addTo(CLI::App& command) {
  const std::string group = "Sweeps of a bag";
  const auto add = [&](const char* name, auto& value, const char* text) {
    return command.add_option(name, value, text)->group(group);
  };
  add("--scan", scan, "LaserScan topic (the only one)");
  add("--joint-states", joint_states, "JointState topic (the only one)");
  add("--joint", joint, "Tilt joint (the one that moves most)");
  command.add_flag("--tilt-from-tf", tilt_from_tf, "Take the tilt from /tf, not from joint states")->group(group);
  add("--axis", axis, "Tilt axis, '-' for the opposite sense")
      ->check(CLI::IsMember({"roll", "pitch", "yaw", "-roll", "-pitch", "-yaw"}))
      ->capture_default_str();
  add("--motion", motion, "Motion of the motor")
      ->check(CLI::IsMember({"nodding", "half_turn", "full_turn"}))
      ->capture_default_str();
  add("--lever-arm", lever_arm, "Laser in the tilting frame, x y z [m] (from /tf)")
      ->expected(3)
      ->check(numberIn(-1000.0, 1000.0));
  add("--mount-rpy", mount_rpy, "Rotation of the laser in the tilting frame, roll pitch yaw [rad] (from /tf)")
      ->expected(3)
      ->check(numberIn(-6.3, 6.3));
  add("--base-frame", base_frame, "Frame of the range images (from /tf)");
  add("--time-offset", time_offset, "Added to the stamps of scans [s]")->check(numberIn(-1e9, 1e9));
  add("--turn-hysteresis", sweep.turn_hysteresis, "Way back that makes a turning point [rad]")
      ->check(numberIn(0.0, 3.0))
      ->capture_default_str();
  add("--min-lines", sweep.min_lines, "Smaller sweeps are dropped")->check(CLI::Range(1, 100000))->capture_default_str();
  add("--max-lines", sweep.max_lines, "Longer sweeps are cut")->check(CLI::Range(1, 100000))->capture_default_str();
}

LineAccounts readSweeps(const std::string& path, const BagOptions& options,
                        const std::function<void(const rosbag::MessageInstance&)>& on_message,
                        const std::function<void(BagSweep&&)>& on_sweep, const std::function<void(double)>& on_progress) {
  if (options.sweep.min_lines > options.sweep.max_lines) {
    throw std::runtime_error("--min-lines " + std::to_string(options.sweep.min_lines) + " exceeds --max-lines " +
                             std::to_string(options.sweep.max_lines));
  }
  requireReadableFile(path);
  checkBag(path);
  rosbag::Bag bag;
  BagTilt tilt;
  try {
    const Quiet quiet;
    bag.open(path, rosbag::bagmode::Read);
    tilt = findTilt(bag, options);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": is no bag, or damaged (" + error.what() + ")");
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  LineAccounts accounts;
  FirstFaults faults;
  try {
    accounts = assemble(bag, tilt, options, on_message, on_sweep, on_progress, faults);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": is damaged (" + error.what() + ")");
  } catch (const DamagedMessage& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  const std::string losses = lossesOf(accounts, faults);
  const std::string lines = std::to_string(accounts.lines_in) + " lines" + (losses.empty() ? "" : ": " + losses);
  if (accounts.sweeps == 0) throw std::runtime_error(path + ": no sweep in " + lines);
  if (!tilt.note.empty()) std::fprintf(stderr, "%s: %s\n", path.c_str(), tilt.note.c_str());
  if (!losses.empty()) {
    std::fprintf(stderr, "%s: %llu rows of %s\n", path.c_str(), static_cast<unsigned long long>(accounts.lines_in_images),
                 lines.c_str());
  }
  return accounts;
}

void showProgress(double share) {
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  static int shown = -1;
  const int percent = static_cast<int>(share * 100.0);
  if (!terminal || percent == shown) return;
  shown = percent;
  const int filled = percent * 40 / 100;
  std::fprintf(stderr, "\r[%.*s%.*s] %3d %%%s", filled, "########################################", 40 - filled,
               "                                        ", percent, percent == 100 ? "\n" : "");
}

}  // namespace ppc
