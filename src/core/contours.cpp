// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/contours.h"

#include "patch_plane_clustering/core/label_runs.h"

#include <memory>
#include <utility>

namespace ppc {
namespace {

// Directions of travel, clockwise: right, down, left, up.
constexpr int kRowStep[4] = {0, 1, 0, -1};
constexpr int kColStep[4] = {1, 0, -1, 0};
constexpr int kDown = 1;
constexpr int kUp = 3;

// Pixels of one label side by side in a row.
struct Run {
  std::int32_t label;
  int row, begin, end;
};

class Tracer {
 public:
  // The sides of a pixel are only looked at where runs begin and end: the rest stays untouched.
  explicit Tracer(const LabelImage& labels)
      : labels_(labels), left_(new int[labels.labels.size()]), right_seen_(new bool[labels.labels.size()]) {}

  PixelContours run() {
    std::vector<Run> runs;
    for (int r = 0; r < labels_.rows; ++r) {
      const std::int32_t* line = labels_.labels.data() + offset(r, 0);
      for (int begin = 0, end = 0; begin < labels_.cols; begin = end) {
        end = runEnd(line, begin, labels_.cols);
        if (line[begin] <= 0) continue;
        runs.push_back({line[begin], r, begin, end});
        left_[offset(r, begin)] = kUnseen;
        right_seen_[offset(r, end - 1)] = false;
      }
    }
    result_.corners.reserve(4 * runs.size());
    for (const Run& run : runs) {
      // The first side met of a new component is the left side of its topmost row: part of the outer ring.
      const int& component = left_[offset(run.row, run.begin)];
      if (component == kUnseen) trace(run.row + 1, run.begin, kUp, run.label, result_.components++, false);
      // The first side met of a new hole is the right side of the run before it.
      if (!right_seen_[offset(run.row, run.end - 1)]) trace(run.row, run.end, kDown, run.label, component, true);
    }
    return std::move(result_);
  }

 private:
  static constexpr int kUnseen = -1;

  std::size_t offset(int r, int c) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(labels_.cols) + static_cast<std::size_t>(c);
  }

  bool inside(int r, int c, std::int32_t label) const {
    return r >= 0 && r < labels_.rows && c >= 0 && c < labels_.cols && labels_.labels[offset(r, c)] == label;
  }

  void trace(int row, int col, int direction, std::int32_t label, int component, bool hole) {
    PixelRing ring{label, component, hole, 0, result_.corners.size(), 0};
    const int first_row = row, first_col = col, first_direction = direction;
    long long area = 0;
    do {
      if (direction == kUp) {
        left_[offset(row - 1, col)] = component;
        area -= col;
      } else if (direction == kDown) {
        right_seen_[offset(row, col - 1)] = true;
        area += col;
      }
      row += kRowStep[direction];
      col += kColStep[direction];
      // Pixels ahead of the corner, to the left and to the right of the direction of travel.
      const int right = (direction + 1) & 3;
      const int ahead_row = row + (kRowStep[direction] + kRowStep[right] - 1) / 2;
      const int ahead_col = col + (kColStep[direction] + kColStep[right] - 1) / 2;
      const bool ahead_right = inside(ahead_row, ahead_col, label);
      const bool ahead_left = inside(ahead_row - kRowStep[right], ahead_col - kColStep[right], label);
      PixelCorner corner{row, col, 0, 0};
      if (!ahead_right) {
        if (ahead_left) {  // diagonal touch: stay with the own pixel, behind and to the right
          corner.pull_row = static_cast<std::int8_t>(kRowStep[right] - kRowStep[direction]);
          corner.pull_col = static_cast<std::int8_t>(kColStep[right] - kColStep[direction]);
        }
        direction = right;
      } else if (ahead_left) {
        direction = (direction + 3) & 3;
      }
      result_.corners.push_back(corner);
    } while (row != first_row || col != first_col || direction != first_direction);
    ring.end = result_.corners.size();
    ring.pixels = static_cast<int>(hole ? -area : area);
    result_.rings.push_back(ring);
  }

  const LabelImage& labels_;
  std::unique_ptr<int[]> left_;         // component whose outline runs along the left side of a pixel
  std::unique_ptr<bool[]> right_seen_;  // whether an outline along the right side of a pixel has been followed
  PixelContours result_;
};

}  // namespace

PixelContours traceContours(const LabelImage& labels) { return Tracer(labels).run(); }

}  // namespace ppc
