// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_fringe.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr int kPart = 16;             // pixels of a fringe that are judged together, about
constexpr double kSignificant = 3.0;  // standard deviations of their mean

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

void listFringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, FringeMemory& memory) {
  memory.runs.clear();
  for (const PixelStretch* block = begin; block != end; ++block) appendRun({1, block->begin, block->end}, memory.runs);
  cutAtRows(memory.runs, grid.rows, grid.cols, memory.rows);
  for (std::vector<int>& side : memory.fringe) side.clear();
  if (memory.runs.empty()) return;
  const int last = (memory.runs.back().end - 1) / grid.cols;
  for (int r = memory.runs.front().begin / grid.cols; r <= last; ++r) {
    listUncovered(memory.rows, r, r - 1, grid.cols, memory.fringe[kAbove]);
    listUncovered(memory.rows, r, r + 1, grid.cols, memory.fringe[kBelow]);
    for (const LabelRun* run = memory.rows.begin(r); run != memory.rows.end(r); ++run) {
      memory.fringe[kBefore].push_back(grid.index(r, run->begin));
      memory.fringe[kAfter].push_back(grid.index(r, run->end - 1));
    }
  }
}

}  // namespace

const std::vector<PixelStretch>& offFringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end,
                                           const Plane& plane, double sigma, const ErrorScale& scale, FringeMemory& memory) {
  listFringe(grid, begin, end, memory);
  const auto error = [&](int i) {  // across the plane, so weighted; beams see it from the side that its normal points to
    if (!grid.valid(i)) return 0.0;
    const double cosine = plane.normal.dot(grid.direction(i).cast<double>());
    const double height = plane.signedDistance(grid.point(i).cast<double>());
    const double weighted = height * std::sqrt((1.0 + scale.softness) / (cosine * cosine + scale.softness));
    return std::clamp(weighted, -scale.limit, scale.limit);
  };
  std::vector<int>& off = memory.off;
  off.clear();
  for (const std::vector<int>& side : memory.fringe) {
    const int count = static_cast<int>(side.size()), parts = (count + kPart - 1) / kPart;
    for (int k = 0; k < parts; ++k) {
      const auto first = side.begin() + partBegin(count, parts, k), last = side.begin() + partBegin(count, parts, k + 1);
      double sum = 0.0;
      for (auto i = first; i != last; ++i) sum += error(*i);
      if (std::abs(sum) > kSignificant * sigma * std::sqrt(static_cast<double>(last - first))) {
        off.insert(off.end(), first, last);
      }
    }
  }
  std::sort(off.begin(), off.end());
  off.erase(std::unique(off.begin(), off.end()), off.end());
  memory.stretches.clear();
  for (const int i : off) {
    if (!memory.stretches.empty() && memory.stretches.back().end == i) {
      ++memory.stretches.back().end;
    } else {
      memory.stretches.push_back({i, i + 1});
    }
  }
  return memory.stretches;
}

}  // namespace ppc
