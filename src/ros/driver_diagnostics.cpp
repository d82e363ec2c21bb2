// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/driver_diagnostics.h"

#include <algorithm>

namespace ppc {
namespace {

constexpr double kSilence = 2.0;   // [s]
constexpr double kPatience = 1.0;  // [s]

using diagnostic_msgs::DiagnosticStatus;

}  // namespace

void DriverDiagnostics::write(const DriverHealth& health, double elapsed,
                              diagnostic_updater::DiagnosticStatusWrapper& status) {
  const auto rate = [elapsed](std::uint64_t now, std::uint64_t before) {
    return elapsed > 0.0 ? static_cast<double>(now - before) / elapsed : 0.0;
  };
  const bool from_tf = health.joint_name.empty();
  status.summary(DiagnosticStatus::OK, "sweeping");
  if (health.scan_age > kSilence) {
    status.mergeSummary(DiagnosticStatus::ERROR, "no scans on " + health.scan_topic);
  }
  if (!from_tf && health.joint_age > kSilence) {
    status.mergeSummary(DiagnosticStatus::ERROR,
                        "no samples of joint '" + health.joint_name + "' on " + health.joint_topic +
                            (health.other_joints.empty() ? "" : ", only of " + health.other_joints));
  }
  const bool no_use = health.joint_samples > last_.joint_samples && health.track.accepted == last_.track.accepted;
  if (!from_tf && health.joint_age <= kSilence && no_use) {
    status.mergeSummary(DiagnosticStatus::ERROR, "no sample of joint '" + health.joint_name + "' can be used");
  }
  if (!health.waits_for.empty() && health.row_age > kPatience) {
    status.mergeSummary(DiagnosticStatus::WARN, "lines wait for " + health.waits_for);
  }
  if (health.sweep_age > health.sweep_timeout) {
    status.mergeSummaryf(DiagnosticStatus::WARN, "no sweep for %.0f s", health.sweep_age);
  }
  if (!from_tf && health.mount.empty() && health.scan_age <= kSilence) {
    status.mergeSummary(DiagnosticStatus::WARN, "waiting for the laser's mount from tf");
  }
  if (health.standing) status.mergeSummary(DiagnosticStatus::WARN, "tilt stands still");
  for (std::size_t i = 0; i < kDropCauses; ++i) {
    const auto cause = static_cast<DropCause>(i);
    const std::uint64_t fresh = health.lines.drops(cause) - last_.lines.drops(cause);
    if (fresh == 0 || cause == DropCause::kSkipped || cause == DropCause::kTiltStanding) continue;
    status.mergeSummaryf(DiagnosticStatus::WARN, "%llu lines dropped: %s", static_cast<unsigned long long>(fresh),
                         dropCauseName(cause));
  }
  if (!health.last_fault.empty()) status.mergeSummary(DiagnosticStatus::WARN, health.last_fault);
  if (health.bad_joint_messages + health.track.implausible + health.track.not_finite >
      last_.bad_joint_messages + last_.track.implausible + last_.track.not_finite) {
    status.mergeSummary(DiagnosticStatus::WARN, from_tf ? "bad samples of the tilt in tf" : "bad joint samples");
  }
  if (health.lost > last_.lost) {
    status.mergeSummaryf(DiagnosticStatus::WARN, "%u scans lost on the way", health.lost - last_.lost);
  }
  if (health.track.jumps > last_.track.jumps) {
    status.mergeSummary(DiagnosticStatus::WARN, from_tf ? "the tilt jumped in tf" : "the joint's angle jumped");
  }
  if (health.lines.layout_changes > last_.lines.layout_changes) {
    status.mergeSummary(DiagnosticStatus::WARN, "the scan's layout changed");
  }
  if (health.lines.clock_resets + health.track.clock_resets > last_.lines.clock_resets + last_.track.clock_resets) {
    status.mergeSummary(DiagnosticStatus::WARN, "the clock jumped back");
  }

  status.add("Scan rate [Hz]", rate(health.scans, last_.scans));
  if (!from_tf) status.add("Joint rate [Hz]", rate(health.joint_samples, last_.joint_samples));
  status.add("Tilt from", from_tf ? std::string("tf") : "joint " + health.joint_name);
  if (!from_tf) status.add("Mount of the laser", health.mount.empty() ? "not known" : health.mount);
  status.add("Scans lost on the way", health.lost);
  status.add("Sweeps", health.lines.sweeps);
  status.add("Time since last sweep [s]", health.sweep_age);
  status.add("Lines in", health.lines.lines_in);
  status.add("Lines in images", health.lines.lines_in_images);
  status.add("Lines pending", health.lines.pending);
  for (std::size_t i = 0; i < kDropCauses; ++i) {
    const auto cause = static_cast<DropCause>(i);
    status.add(std::string("Lines dropped: ") + dropCauseName(cause), health.lines.drops(cause));
  }
  status.add("Layout changes", health.lines.layout_changes);
  status.add("Clock resets", std::max(health.lines.clock_resets, health.track.clock_resets));
  const std::string origin = from_tf ? "Tf" : "Joint";
  status.add(origin + " samples used", health.track.accepted);
  status.add(origin + " jumps", health.track.jumps);
  status.add(origin + " samples rejected: not newer", health.track.not_newer);
  status.add(origin + " samples rejected: not finite", health.track.not_finite);
  status.add(origin + " samples rejected: implausible", health.track.implausible);
  if (!from_tf) status.add("Joint messages rejected: incomplete", health.bad_joint_messages);
  last_ = health;
}

std::string DriverDiagnostics::news(const diagnostic_updater::DiagnosticStatusWrapper& status) {
  constexpr int kLasting = 5, kAgain = 30;
  if (status.level == DiagnosticStatus::OK) {
    const bool over = troubled_reports_ >= kLasting;
    troubled_reports_ = 0;
    return over ? "The driver is well again" : "";
  }
  const bool tell = troubled_reports_ % kAgain == kLasting - 1;
  ++troubled_reports_;
  return tell ? "The driver is in trouble: " + status.message : "";
}

}  // namespace ppc
