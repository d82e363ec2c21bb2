// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_fringe.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace ppc {
namespace {

constexpr int kPart = 16;  // pixels of a fringe that are judged together, about

enum Side : std::size_t { kAbove, kBelow, kBefore, kAfter };

// Pixels of one row that have none of the region next to them in the other row.
void listUncovered(const RowRuns& runs, int row, int other, int cols, std::vector<int>& out) {
  const bool inside = other >= 0 && other < runs.rows();
  const LabelRun *next = inside ? runs.begin(other) : nullptr, *const last = inside ? runs.end(other) : nullptr;
  for (const LabelRun* run = runs.begin(row); run != runs.end(row); ++run) {
    int at = run->begin;
    while (next != last && next->end <= at) ++next;
    for (const LabelRun* cover = next; at < run->end; ++cover) {
      const bool more = cover != last && cover->begin < run->end;
      for (const int stop = more ? cover->begin : run->end; at < stop; ++at) out.push_back(row * cols + at);
      if (!more) break;
      at = cover->end;
    }
  }
}

// What tells whether a part of a fringe is off a plane.
class Jury {
 public:
  using Pixel = std::vector<int>::const_iterator;

  Jury(const BeamGrid& grid, const FringeJudge& judge, const ErrorScale& scale)
      : grid_(grid), judge_(judge), scale_(scale) {}

  bool isOff(Pixel first, Pixel last) const {
    double sum = 0.0, count = 0.0;
    for (auto i = first; i != last; ++i) {
      if (!grid_.valid(*i)) continue;
      sum += errorOf(*i);
      ++count;
    }
    if (count == 0.0) return false;
    const double variance = judge_.sigma * judge_.sigma / count + planeVarianceAt(middleOf(first, last));
    return std::abs(sum) > judge_.significance * count * std::sqrt(variance);
  }

 private:
  // Across the plane, so weighted; beams see it from the side that its normal points to.
  double errorOf(int i) const {
    const double height = judge_.plane.signedDistance(grid_.point(i).cast<double>());
    return std::clamp(height * std::sqrt(weightOf(i)), -scale_.limit, scale_.limit);
  }

  // Of what the plane is allowed and not known, weighted likewise.
  double planeVarianceAt(int i) const {
    Eigen::Vector4d derivative;
    derivative << grid_.point(i).cast<double>(), -1.0;
    const double variance = judge_.tolerance * judge_.tolerance + derivative.dot(judge_.covariance * derivative);
    return variance > 0.0 ? variance * weightOf(i) : 0.0;  // edge-on the weight may be infinite
  }

  double weightOf(int i) const {
    const double cosine = judge_.plane.normal.dot(grid_.direction(i).cast<double>());
    return (1.0 + scale_.softness) / (cosine * cosine + scale_.softness);
  }

  // A pixel that is measured, near the middle.
  int middleOf(Pixel first, Pixel last) const {
    const auto middle = first + (last - first) / 2;
    const auto is_valid = [&](int i) { return grid_.valid(i); };
    const auto found = std::find_if(middle, last, is_valid);
    return found != last ? *found
                         : *std::find_if(std::make_reverse_iterator(middle), std::make_reverse_iterator(first), is_valid);
  }

  const BeamGrid& grid_;
  const FringeJudge& judge_;
  const ErrorScale& scale_;
};

}  // namespace

Fringe::Fringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, FringeMemory& memory)
    : grid_(grid), memory_(memory) {
  memory.runs.clear();
  for (const PixelStretch* block = begin; block != end; ++block) appendRun({1, block->begin, block->end}, memory.runs);
  cutAtRows(memory.runs, grid.rows, grid.cols, memory.rows);
  for (std::vector<int>& side : memory.sides) side.clear();
  if (memory.runs.empty()) return;
  const int last = (memory.runs.back().end - 1) / grid.cols;
  for (int r = memory.runs.front().begin / grid.cols; r <= last; ++r) {
    listUncovered(memory.rows, r, r - 1, grid.cols, memory.sides[kAbove]);
    listUncovered(memory.rows, r, r + 1, grid.cols, memory.sides[kBelow]);
    for (const LabelRun* run = memory.rows.begin(r); run != memory.rows.end(r); ++run) {
      memory.sides[kBefore].push_back(grid.index(r, run->begin));
      memory.sides[kAfter].push_back(grid.index(r, run->end - 1));
    }
  }
}

const std::vector<PixelStretch>& Fringe::all() {
  memory_.pixels.clear();
  for (const std::vector<int>& side : memory_.sides) {
    memory_.pixels.insert(memory_.pixels.end(), side.begin(), side.end());
  }
  return joinPixels();
}

const std::vector<PixelStretch>& Fringe::off(std::initializer_list<FringeJudge> judges, const ErrorScale& scale) {
  memory_.pixels.clear();
  for (const FringeJudge& judge : judges) {
    const Jury jury(grid_, judge, scale);
    for (const std::vector<int>& side : memory_.sides) {
      const int count = static_cast<int>(side.size()), parts = (count + kPart - 1) / kPart;
      for (int k = 0; k < parts; ++k) {
        const auto first = side.begin() + partBegin(count, parts, k), last = side.begin() + partBegin(count, parts, k + 1);
        if (jury.isOff(first, last)) memory_.pixels.insert(memory_.pixels.end(), first, last);
      }
    }
  }
  return joinPixels();
}

const std::vector<PixelStretch>& Fringe::joinPixels() {
  std::vector<int>& pixels = memory_.pixels;
  std::sort(pixels.begin(), pixels.end());
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  memory_.stretches.clear();
  for (const int i : pixels) {
    if (!memory_.stretches.empty() && memory_.stretches.back().end == i) {
      ++memory_.stretches.back().end;
    } else {
      memory_.stretches.push_back({i, i + 1});
    }
  }
  return memory_.stretches;
}

}  // namespace ppc
