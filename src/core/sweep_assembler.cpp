// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/sweep_assembler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ppc {
namespace {

constexpr double kClockJump = 1.0;         // [s]
constexpr std::size_t kConfirmations = 3;  // lines that tell the time: fewer may be strays
constexpr double kLongAgo = -std::numeric_limits<double>::infinity();

DropCause causeOf(PoseStatus status) {
  switch (status) {
    case PoseStatus::kWait:
    case PoseStatus::kNoTilt:
      return DropCause::kNoTilt;
    case PoseStatus::kTiltGap:
      return DropCause::kTiltGap;
    default:
      return DropCause::kNoTransform;
  }
}

}  // namespace

const char* sweepEndName(SweepEnd end) {
  switch (end) {
    case SweepEnd::kTurn:
      return "turn";
    case SweepEnd::kRequest:
      return "request";
    case SweepEnd::kIdle:
      return "idle";
    case SweepEnd::kLayoutChange:
      return "layout change";
    case SweepEnd::kLineGap:
      return "line gap";
    case SweepEnd::kStanding:
      return "standing tilt";
    case SweepEnd::kTiltJump:
      return "tilt jump";
    case SweepEnd::kMaxLines:
      return "most lines";
  }
  return "unknown";
}

SweepAssembler::SweepAssembler(const SweepOptions& options, PoseSource& poses, Handler handler)
    : options_(options),
      poses_(poses),
      handler_(std::move(handler)),
      splitter_(options.motion, options.turn_hysteresis),
      last_placed_(kLongAgo) {}

std::string SweepAssembler::push(ScanLine line) {
  ++accounts_.lines_in;
  std::string fault = faultOf(line);
  if (!fault.empty()) {
    ++accounts_.dropped[static_cast<std::size_t>(DropCause::kBadScan)];
    return fault;
  }
  ++accounts_.pending;
  if (options_.skip > 0 && (accounts_.lines_in - 1) % static_cast<std::uint64_t>(options_.skip + 1) != 0) {
    drop(DropCause::kSkipped);
    return {};
  }
  if (line.stamp < last_placed_ - kClockJump) {
    if (!suspects_.empty() && line.stamp <= suspects_.back().stamp) {
      drop(DropCause::kOutOfOrder, suspects_.size());
      suspects_.clear();
    }
    suspects_.push_back(std::move(line));
    if (suspects_.size() >= kConfirmations) resetClock();
  } else {
    drop(DropCause::kOutOfOrder, suspects_.size());
    suspects_.clear();
    enqueue(std::move(line));
  }
  process();
  return {};
}

void SweepAssembler::resetClock() {
  ++accounts_.clock_resets;
  drop(DropCause::kClockReset, queue_.size() + open_.size());
  queue_.clear();
  open_.clear();
  restart();
  standing_ = -1;
  last_placed_ = kLongAgo;
  poses_.resetClock(suspects_.back().stamp);
  clock_resets_ = poses_.clockResets();
  for (ScanLine& line : suspects_) enqueue(std::move(line));
  suspects_.clear();
}

void SweepAssembler::enqueue(ScanLine line) {
  const auto at = std::lower_bound(queue_.begin(), queue_.end(), line.stamp,
                                   [](const WaitingLine& queued, double stamp) { return queued.line.stamp < stamp; });
  if (line.stamp == last_placed_ || (at != queue_.end() && at->line.stamp == line.stamp)) return drop(DropCause::kDuplicate);
  if (line.stamp < last_placed_) return drop(DropCause::kOutOfOrder);
  queue_.insert(at, {std::move(line), accounts_.lines_in});
}

void SweepAssembler::process() {
  if (poses_.jumps() != jumps_) recheckAfterJump();
  if (poses_.clockResets() != clock_resets_) dropWaiting();
  placeWaiting();
  while (queue_.size() > static_cast<std::size_t>(options_.max_queue)) {
    // The first to arrive, not the first in time: lines with a stamp in the far future must not starve the others.
    queue_.erase(std::min_element(queue_.begin(), queue_.end(),
                                  [](const WaitingLine& a, const WaitingLine& b) { return a.arrival < b.arrival; }));
    drop(DropCause::kQueueFull);
  }
}

bool SweepAssembler::overdue() {
  const auto late = [this] {
    return queue_.size() > kConfirmations &&
           queue_[queue_.size() - kConfirmations].line.stamp - queue_.front().line.stamp > options_.max_wait;
  };
  if (late()) dropHopeless();
  return late();
}

void SweepAssembler::placeWaiting() {
  waits_for_ = PoseStatus::kReady;
  while (!queue_.empty()) {
    PlacedLine placed;
    const PoseStatus status = place(queue_.front().line, placed);
    if (waits(status) && !overdue()) {
      waits_for_ = status;
      break;
    }
    placed.line = std::move(queue_.front().line);
    queue_.pop_front();
    if (status == PoseStatus::kReady) {
      last_placed_ = placed.line.stamp;
      add(std::move(placed));
    } else {
      drop(causeOf(status));
    }
  }
}

// Lines with a stamp in the far future never come to the front, and would make all others look overdue.
void SweepAssembler::dropHopeless() {
  LaserPose pose;
  while (queue_.size() > 1) {
    const PoseStatus status = poses_.at(queue_.back().line.lastStamp(), pose);
    if (waits(status) || status == PoseStatus::kReady) return;
    queue_.pop_back();
    drop(causeOf(status));
  }
}

// The samples that these lines wait for will never come; those that come are of other times.
void SweepAssembler::dropWaiting() {
  clock_resets_ = poses_.clockResets();
  drop(DropCause::kClockReset, queue_.size());
  queue_.clear();
}

void SweepAssembler::recheckAfterJump() {
  jumps_ = poses_.jumps();
  PlacedLine placed;
  while (!open_.empty() && place(open_.back().line, placed) == PoseStatus::kTiltGap) {
    open_.pop_back();
    drop(DropCause::kTiltGap);
    cut_ = true;
  }
  // Other lines from before the jump may still wait: add() ends the sweep at the first one after it.
}

PoseStatus SweepAssembler::place(const ScanLine& line, PlacedLine& placed) const {
  const int poses = options_.poses_per_row;
  const auto last_beam = static_cast<double>(line.ranges.size() - 1);
  LaserPose at;
  // The last beam first: it is the one that makes a line wait.
  PoseStatus status = poses_.at(line.lastStamp(), at);
  if (status != PoseStatus::kReady) return status;
  placed.base = at.base;
  placed.poses.resize(static_cast<std::size_t>(poses));
  placed.poses.back() = at.pose;
  for (int k = 0; k + 1 < poses; ++k) {
    status = poses_.at(line.beamStamp(last_beam * k / (poses - 1)), at);
    if (status != PoseStatus::kReady) return status;
    placed.poses[static_cast<std::size_t>(k)] = at.pose;
  }
  status = poses_.at(line.beamStamp(0.5 * last_beam), at);
  if (status != PoseStatus::kReady) return status;
  if (poses == 1) placed.poses[0] = at.pose;
  placed.tilt = at.tilt;
  return PoseStatus::kReady;
}

bool SweepAssembler::followStanding(double tilt) {
  if (standing_ < 0 || std::abs(tilt - standing_at_) > 0.5 * options_.turn_hysteresis) {
    standing_at_ = tilt;
    standing_ = 0;
    return false;
  }
  if (standing()) return true;
  if (++standing_ < options_.standing_lines) return false;
  // Only now is it known that the motor has stood since: those lines would be so many copies of one row.
  const std::size_t stood = std::min(static_cast<std::size_t>(standing_ - 1), open_.size());
  open_.resize(open_.size() - stood);
  drop(DropCause::kTiltStanding, stood);
  close(SweepEnd::kStanding);
  return true;
}

void SweepAssembler::add(PlacedLine placed) {
  if (!open_.empty()) {
    const ScanLine& last = open_.back().line;
    const bool paused = placed.line.stamp - last.stamp > options_.max_line_gap;
    if (!sameLayout(last, placed.line)) {
      ++accounts_.layout_changes;
      close(SweepEnd::kLayoutChange);
    } else if (cut_ || (!paused && poses_.jumpedBetween(last.stamp, placed.line.stamp))) {
      close(SweepEnd::kTiltJump);
    } else if (paused) {
      close(SweepEnd::kLineGap);
    }
  }
  if (open_.empty()) restart();
  if (followStanding(placed.tilt)) return drop(DropCause::kTiltStanding);
  const double tilt = placed.tilt;
  open_.push_back(std::move(placed));
  const std::size_t completed = splitter_.feed(tilt);
  if (completed > 0) emit(completed, SweepEnd::kTurn);
  tellForeseen();
  if (open_.size() >= static_cast<std::size_t>(options_.max_lines)) close(SweepEnd::kMaxLines);
}

void SweepAssembler::restart() {
  splitter_.restart();
  told_ = 0;
  cut_ = false;
}

int SweepAssembler::close(SweepEnd reason) {
  restart();
  return emit(open_.size(), reason);
}

void SweepAssembler::tellForeseen() {
  const std::size_t lines = splitter_.foreseen();
  if (lines == 0 || lines == told_ || !foreseen_handler_) return;
  told_ = lines;
  Sweep sweep;
  if (assemble(lines, sweep)) foreseen_handler_(std::move(sweep));
}

int SweepAssembler::emit(std::size_t lines, SweepEnd reason) {
  if (lines == 0) return 0;
  Sweep sweep;
  sweep.end = reason;
  const bool large_enough = assemble(lines, sweep);
  open_.erase(open_.begin(), open_.begin() + static_cast<std::ptrdiff_t>(lines));
  told_ = 0;
  if (!large_enough) {
    drop(DropCause::kSweepTooSmall, lines);
    return 0;
  }
  accounts_.pending -= lines;
  accounts_.lines_in_images += lines;
  ++accounts_.sweeps;
  sweep.accounts = accounts_;
  sweep.accounts.lines_in -= queue_.size() + suspects_.size();
  sweep.accounts.pending -= queue_.size() + suspects_.size();
  handler_(std::move(sweep));
  return static_cast<int>(lines);
}

// The image and stamp of the first lines of the open sweep. False if they are too few, or span too little.
bool SweepAssembler::assemble(std::size_t lines, Sweep& sweep) const {
  std::vector<const PlacedLine*> rows(lines);
  std::transform(open_.begin(), open_.begin() + static_cast<std::ptrdiff_t>(lines), rows.begin(),
                 [](const PlacedLine& line) { return &line; });
  const PlacedLine& newest = **std::max_element(rows.begin(), rows.end(), [](const PlacedLine* a, const PlacedLine* b) {
    return a->line.lastStamp() < b->line.lastStamp();
  });
  sweep.stamp = newest.line.lastStamp();
  const Eigen::Isometry3d world_in_base = newest.base.inverse();

  std::stable_sort(rows.begin(), rows.end(), [](const auto* a, const auto* b) { return a->tilt < b->tilt; });
  const double lowest = rows.front()->tilt, highest = rows.back()->tilt;
  if (lines < static_cast<std::size_t>(options_.min_lines) || highest - lowest < options_.min_tilt_span) return false;
  // Round and round, the joint's angle grows without end; the tilts of the image do not.
  constexpr double kPi = 3.141592653589793;
  const double middle = 0.5 * (lowest + highest);
  const double turns = options_.motion == SweepMotion::kNodding ? 0.0 : 2.0 * kPi * std::floor((middle + kPi) / (2.0 * kPi));

  RangeImage& image = sweep.image;
  const ScanLine& layout = rows.front()->line;
  image.rows = static_cast<int>(lines);
  image.cols = static_cast<int>(layout.ranges.size());
  image.bearing_min = layout.bearing_min;
  image.bearing_increment = layout.bearing_increment;
  image.range_min = layout.range_min;
  image.range_max = layout.range_max;
  image.poses_per_row = options_.poses_per_row;
  image.ranges.reserve(lines * layout.ranges.size());
  const bool intense = std::none_of(rows.begin(), rows.end(), [](const auto* row) { return row->line.intensities.empty(); });
  for (const PlacedLine* row : rows) {
    const ScanLine& line = row->line;
    image.ranges.insert(image.ranges.end(), line.ranges.begin(), line.ranges.end());
    if (intense) image.intensities.insert(image.intensities.end(), line.intensities.begin(), line.intensities.end());
    for (const Eigen::Isometry3d& pose : row->poses) image.line_poses.push_back(world_in_base * pose);
    image.tilts.push_back(row->tilt - turns);
    image.row_stamps.push_back(line.stamp);
  }
  return true;
}

void SweepAssembler::countDropped(DropCause cause) {
  ++accounts_.lines_in;
  ++accounts_.dropped[static_cast<std::size_t>(cause)];
}

void SweepAssembler::drop(DropCause cause, std::size_t lines) {
  accounts_.pending -= lines;
  accounts_.dropped[static_cast<std::size_t>(cause)] += lines;
}

}  // namespace ppc
