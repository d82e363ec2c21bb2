// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/contours.h"

#include <algorithm>

namespace ppc {
namespace {

// Directions of travel, clockwise: right, down, left, up.
constexpr int kRowStep[4] = {0, 1, 0, -1};
constexpr int kColStep[4] = {1, 0, -1, 0};
constexpr int kDown = 1;
constexpr int kUp = 3;

// From a corner to the pixels ahead of it, to the right and to the left of the direction of travel.
constexpr int kRightRow[4] = {0, 0, -1, -1};
constexpr int kRightCol[4] = {0, -1, -1, 0};
constexpr int kLeftRow[4] = {-1, 0, 0, -1};
constexpr int kLeftCol[4] = {0, 0, -1, -1};

class Tracer {
 public:
  Tracer(const LabelImage& labels, ContourMemory& memory, PixelContours& out) : labels_(labels), memory_(memory), out_(out) {
    memory.left.resize(std::max(memory.left.size(), labels.labels.size()));
    memory.right_seen.resize(std::max(memory.right_seen.size(), labels.labels.size()));
    out.corners.clear();
    out.rings.clear();
    out.components = 0;
  }

  void trace(const std::vector<LabelRun>& runs) {
    // The sides of a pixel are only looked at where runs begin and end: the rest stays untouched.
    forEachRowRun(runs, [&](const LabelRun& run, int, int) {
      memory_.left[run.begin] = kUnseen;
      memory_.right_seen[run.end - 1] = 0;
    });
    forEachRowRun(runs, [&](const LabelRun& run, int row, int first) {
      // The first side met of a new component is the left side of its topmost row: part of the outer ring.
      const int& component = memory_.left[run.begin];
      if (component == kUnseen) follow(row + 1, run.begin - first, kUp, run.label, out_.components++, false);
      // The first side met of a new hole is the right side of the run before it.
      if (memory_.right_seen[run.end - 1] == 0) follow(row, run.end - first, kDown, run.label, component, true);
    });
  }

 private:
  static constexpr int kUnseen = -1;

  // Calls f(run, row, first pixel of the row) for all runs, which are cut where a row ends.
  template <typename F>
  void forEachRowRun(const std::vector<LabelRun>& runs, const F& f) const {
    int row = 0, first = 0;
    for (const LabelRun& run : runs) {
      for (int begin = run.begin; begin < run.end;) {
        for (; begin >= first + labels_.cols; first += labels_.cols) ++row;
        const int end = std::min(run.end, first + labels_.cols);
        f(LabelRun{run.label, begin, end}, row, first);
        begin = end;
      }
    }
  }

  bool inside(int r, int c, std::int32_t label) const {
    // A negative number is a large one without its sign.
    return static_cast<unsigned>(r) < static_cast<unsigned>(labels_.rows) &&
           static_cast<unsigned>(c) < static_cast<unsigned>(labels_.cols) &&
           labels_.labels[static_cast<std::size_t>(r * labels_.cols + c)] == label;
  }

  void follow(int row, int col, int direction, std::int32_t label, int component, bool hole) {
    PixelRing ring{label, component, hole, 0, out_.corners.size(), 0};
    const int first_row = row, first_col = col, first_direction = direction;
    long long area = 0;
    do {
      if (direction == kUp) {
        memory_.left[(row - 1) * labels_.cols + col] = component;
        area -= col;
      } else if (direction == kDown) {
        memory_.right_seen[row * labels_.cols + col - 1] = 1;
        area += col;
      }
      row += kRowStep[direction];
      col += kColStep[direction];
      const bool ahead_right = inside(row + kRightRow[direction], col + kRightCol[direction], label);
      const bool ahead_left = inside(row + kLeftRow[direction], col + kLeftCol[direction], label);
      PixelCorner corner{row, col, 0, 0};
      if (!ahead_right) {
        const int right = (direction + 1) & 3;
        if (ahead_left) {  // diagonal touch: stay with the own pixel, behind and to the right
          corner.pull_row = static_cast<std::int8_t>(kRowStep[right] - kRowStep[direction]);
          corner.pull_col = static_cast<std::int8_t>(kColStep[right] - kColStep[direction]);
        }
        direction = right;
      } else if (ahead_left) {
        direction = (direction + 3) & 3;
      }
      out_.corners.push_back(corner);
    } while (row != first_row || col != first_col || direction != first_direction);
    ring.end = out_.corners.size();
    ring.pixels = static_cast<int>(hole ? -area : area);
    out_.rings.push_back(ring);
  }

  const LabelImage& labels_;
  ContourMemory& memory_;
  PixelContours& out_;
};

}  // namespace

void traceContours(const LabelImage& labels, const std::vector<LabelRun>& runs, ContourMemory& memory, PixelContours& out) {
  Tracer(labels, memory, out).trace(runs);
}

void traceContours(const LabelImage& labels, ContourMemory& memory, PixelContours& out) {
  listRuns(labels, memory.runs);
  traceContours(labels, memory.runs, memory, out);
}

PixelContours traceContours(const LabelImage& labels) {
  ContourMemory memory;
  PixelContours out;
  traceContours(labels, memory, out);
  return out;
}

}  // namespace ppc
