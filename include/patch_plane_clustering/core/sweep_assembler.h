// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/line_accounts.h"
#include "patch_plane_clustering/core/pose_source.h"
#include "patch_plane_clustering/core/range_image.h"
#include "patch_plane_clustering/core/scan_line.h"
#include "patch_plane_clustering/core/sweep_splitter.h"

#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace ppc {

struct SweepOptions {
  SweepMotion motion = SweepMotion::kNodding;
  double turn_hysteresis = 0.02;  ///< larger than the encoder's noise [rad]
  int poses_per_row = 9;          ///< poses of the laser along each line
  int min_lines = 10;             ///< a sweep of fewer lines is dropped
  int max_lines = 5000;           ///< a sweep is closed when it has this many
  double min_tilt_span = 0.05;    ///< a sweep of a smaller span of tilts is dropped [rad]
  double max_line_gap = 1.0;      ///< a longer pause between placed lines ends the sweep [s]
  int standing_lines = 100;       ///< lines within half the turn hysteresis of one tilt that mean a standing motor
  int skip = 0;                   ///< lines left out between lines used
  int max_queue = 200;            ///< lines that may wait for their poses
  double max_wait = 5.0;          ///< a line waits so long for its poses, by the lines' own clock [s]
};

/// @brief Why a sweep ended.
enum class SweepEnd { kTurn, kRequest, kIdle, kLayoutChange, kLineGap, kStanding, kTiltJump, kMaxLines };
const char* sweepEndName(SweepEnd end);

/// @brief A completed sweep; its image is in the base frame, at `stamp` if the base moves.
struct Sweep {
  RangeImage image;
  double stamp = 0.0;     ///< newest beam [s]
  LineAccounts accounts;  ///< up to the line that ended this sweep: those that still wait for their pose do not count as in
  SweepEnd end = SweepEnd::kTurn;
};

/// @brief Assembles lines into range images.
///
/// A line waits in a queue, ordered by stamp, until its poses are known from its first beam to its last. Placed lines form
/// the open sweep until the tilt turns (see SweepSplitter). All buffers are bounded and every line is accounted for. A clock
/// that jumps back (three lines in a row, more than a second before the last placed one) drops the open sweep. A jump of the
/// tilt ends the sweep, less the lines whose tilt has turned out to be unknown. Sweeps depend on the stamps of lines and
/// tilt samples, not on which of the two arrive first, as long as no line is given up. Deterministic; not thread-safe.
class SweepAssembler {
 public:
  using Handler = std::function<void(Sweep&&)>;

  /// @param poses must outlive the assembler @param handler gets every completed sweep, from within the calls below
  SweepAssembler(const SweepOptions& options, PoseSource& poses, Handler handler);

  /// @brief Asks for sweeps that seem to have ended, some lines before that is certain (SweepSplitter::foreseen()). One that
  /// does end there comes to the handler of completed sweeps with the same image and stamp; others end elsewhere.
  /// @param handler gets them, from within the calls below; their accounts are empty
  void foresee(Handler handler) { foreseen_handler_ = std::move(handler); }

  /// @brief Takes a line and places what can be placed. @return what is wrong with the line (it is dropped then), or empty.
  std::string push(ScanLine line);

  /// @brief Places waiting lines; to be called when new poses may be known.
  void process();

  /// @brief Ends the open sweep. @return rows of the image made; 0 = there was none, or it was too small.
  int close(SweepEnd reason);

  /// @brief Counts a line that was dropped before it could be pushed.
  void countDropped(DropCause cause);

  const LineAccounts& accounts() const { return accounts_; }
  bool standing() const { return standing_ >= options_.standing_lines; }  ///< the tilt does not move
  int openLines() const { return static_cast<int>(open_.size()); }        ///< lines of the open sweep
  double lastPlaced() const { return last_placed_; }  ///< stamp of the last line with a known pose, or -infinity [s]
  PoseStatus waitsFor() const { return waits_for_; }  ///< what the oldest waiting line lacks; kReady if none waits
  /// Oldest line that waits for its pose, or null.
  const ScanLine* oldestWaiting() const { return queue_.empty() ? nullptr : &queue_.front().line; }

 private:
  struct PlacedLine {
    ScanLine line;
    std::vector<Eigen::Isometry3d> poses;  // in the world
    Eigen::Isometry3d base;                // in the world, at the last beam
    double tilt;                           // at the middle of the line
  };
  struct WaitingLine {
    ScanLine line;
    std::uint64_t arrival;
  };
  PoseStatus place(const ScanLine& line, PlacedLine& placed) const;
  void enqueue(ScanLine line);
  void resetClock();
  void placeWaiting();
  bool overdue();
  void dropHopeless();
  void recheckAfterJump();
  void dropWaiting();
  void add(PlacedLine placed);
  bool followStanding(double tilt);
  void restart();
  int emit(std::size_t lines, SweepEnd reason);
  bool assemble(std::size_t lines, Sweep& sweep) const;
  void tellForeseen();
  void drop(DropCause cause, std::size_t lines = 1);

  SweepOptions options_;
  PoseSource& poses_;
  Handler handler_, foreseen_handler_;
  SweepSplitter splitter_;
  LineAccounts accounts_;
  std::deque<WaitingLine> queue_;   // in ascending stamp
  std::vector<ScanLine> suspects_;  // lines from before last_placed_ that may mean a clock reset
  std::vector<PlacedLine> open_;
  std::size_t told_ = 0;  // lines of the open sweep whose end was told to be foreseen last
  bool cut_ = false;      // the newest lines of the open sweep were taken back: no other may join it
  double last_placed_;    // stamp of the last line that joined a sweep [s]
  PoseStatus waits_for_ = PoseStatus::kReady;
  std::uint64_t jumps_ = 0;         // of the tilt, seen so far
  std::uint64_t clock_resets_ = 0;  // of the tilt's clock, seen so far
  double standing_at_ = 0.0;        // tilt that the motor must leave to count as moving [rad]
  int standing_ = -1;               // lines since it was last seen moving; -1 = no line yet
};

}  // namespace ppc
