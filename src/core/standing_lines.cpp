// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/standing_lines.h"

#include "patch_plane_clustering/core/grid_lines.h"
#include "patch_plane_clustering/core/grid_selection.h"
#include "patch_plane_clustering/core/quantile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace ppc {
namespace {

constexpr int kSamples = 10;        // beams by which lines are compared
constexpr std::size_t kFewest = 4;  // of them that both lines have measured
constexpr double kStanding = 0.1;   // of the step of lines that move
constexpr double kMoving = 0.98;    // quantile of the steps: most lines may stand, and some follow a gap
constexpr int kFewestStanding = 8;  // lines one after the other: patches reach over fewer
constexpr int kFewestMoving = 8;    // lines that must be left
// How far two lines that stand may differ: so many times what one difference of ten exceeds, on the same surface.
constexpr float kMostApart = 3.0F;
constexpr double kApart = 0.9;

// Median angle between the beams of two lines; negative if too few of them have measured.
double angleBetween(const GridLines& lines, int a, int b, std::vector<float>& angles) {
  const int step = std::max(1, lines.beams() / kSamples);
  angles.clear();
  for (int beam = step / 2; beam < lines.beams(); beam += step) {
    if (!lines.grid().valid(lines.pixel(a, beam)) || !lines.grid().valid(lines.pixel(b, beam))) continue;
    angles.push_back((lines.direction(a, beam) - lines.direction(b, beam)).norm());
  }
  return angles.size() < kFewest ? -1.0 : quantile(angles, 0.5);
}

// Lists the lines that move, and which of them each line is like. @return whether any are left out.
bool findStanding(const GridLines& lines, StandingLineMemory& memory) {
  memory.steps.assign(1, -1.0);
  memory.known.clear();
  for (int line = 1; line < lines.count(); ++line) {
    memory.steps.push_back(angleBetween(lines, line - 1, line, memory.angles));
    if (memory.steps.back() >= 0.0) memory.known.push_back(memory.steps.back());
  }
  if (memory.known.empty()) return false;
  const double least = kStanding * quantile(memory.known, kMoving);
  const auto stands = [least](double angle) { return angle >= 0.0 && angle < least; };
  memory.kept.clear();
  memory.stands_for.clear();
  bool any = false;
  for (int begin = 0, end = 0; begin < lines.count(); begin = end) {
    for (end = begin + 1; end < lines.count(); ++end) {
      if (!stands(memory.steps[end]) || !stands(angleBetween(lines, begin, end, memory.angles))) break;
    }
    const bool thin = end - begin >= kFewestStanding;
    any = any || thin;
    for (int line = begin; line < end; ++line) {
      if (line == begin || !thin) memory.kept.push_back(line);
      memory.stands_for.push_back(static_cast<int>(memory.kept.size()) - 1);
    }
  }
  return any && static_cast<int>(memory.kept.size()) >= kFewestMoving;
}

// The image of those lines.
void takeKept(const GridLines& lines, StandingLineMemory& memory) {
  memory.beams.resize(static_cast<std::size_t>(lines.beams()));
  std::iota(memory.beams.begin(), memory.beams.end(), 0);
  const bool columns = memory.in_columns;
  selectBeams(lines.grid(), columns ? memory.beams : memory.kept, columns ? memory.kept : memory.beams, memory.grid);
}

// Takes their labels from the pixels of a line that was left out where it has measured something else than the line that
// stands for it, or nothing.
void clearOthers(const GridLines& lines, int line, const GridLines& kept, int of, StandingLineMemory& memory,
                 LabelImage& labels) {
  std::vector<StandingLineMemory::Difference>& differences = memory.differences;
  differences.clear();
  for (int beam = 0; beam < lines.beams(); ++beam) {
    const int pixel = lines.pixel(line, beam);
    std::int32_t& label = labels.labels[pixel];
    if (!lines.grid().valid(pixel)) label = 0;
    if (label == 0) continue;
    differences.push_back({label, std::abs(lines.grid().range[pixel] - kept.grid().range[kept.pixel(of, beam)]), pixel});
  }
  std::sort(differences.begin(), differences.end(),
            [](const auto& a, const auto& b) { return a.label != b.label ? a.label < b.label : a.range < b.range; });
  for (std::size_t begin = 0, end = 0; begin < differences.size(); begin = end) {
    while (end < differences.size() && differences[end].label == differences[begin].label) ++end;
    const auto count = static_cast<double>(end - begin - 1);
    float farthest = kMostApart * differences[begin + static_cast<std::size_t>(kApart * count)].range;
    for (std::size_t k = begin; k < end; ++k) {
      if (farthest == 0.0F) farthest = differences[k].range;  // one step of ranges that come in steps
      if (differences[k].range > farthest) labels.labels[differences[k].pixel] = 0;
    }
  }
}

}  // namespace

bool thinStandingLines(const BeamGrid& grid, StandingLineMemory& memory) {
  for (const bool in_columns : {false, true}) {
    const GridLines lines(grid, in_columns);
    if (!findStanding(lines, memory)) continue;
    memory.in_columns = in_columns;
    takeKept(lines, memory);
    return true;
  }
  return false;
}

void labelStandingLines(const BeamGrid& grid, StandingLineMemory& memory, LabelImage& labels) {
  labels.rows = grid.rows;
  labels.cols = grid.cols;
  labels.labels.resize(static_cast<std::size_t>(grid.size()));
  const GridLines lines(grid, memory.in_columns), kept(memory.grid, memory.in_columns);
  for (int line = 0; line < lines.count(); ++line) {
    const int of = memory.stands_for[line];
    for (int beam = 0; beam < lines.beams(); ++beam) {
      labels.labels[lines.pixel(line, beam)] = memory.labels.labels[kept.pixel(of, beam)];
    }
    if (memory.kept[of] != line) clearOthers(lines, line, kept, of, memory, labels);
  }
}

}  // namespace ppc
