// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_fringe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ppc {
namespace {

constexpr std::size_t kPart = 16;     // pixels of a fringe that are judged together, about
constexpr double kSignificant = 3.0;  // standard deviations of their mean

using Run = FringeMemory::Run;
enum Side : std::size_t { kAbove, kBelow, kBefore, kAfter };

// Blocks may be cut anywhere and go on over the ends of rows.
void listRuns(const PixelStretch* begin, const PixelStretch* end, int cols, std::vector<Run>& runs) {
  runs.clear();
  for (const PixelStretch* block = begin; block != end; ++block) {
    for (int at = block->begin; at < block->end;) {
      const int row = at / cols, first = at - row * cols, last = std::min(block->end - row * cols, cols);
      if (!runs.empty() && runs.back().row == row && runs.back().end == first) {
        runs.back().end = last;
      } else {
        runs.push_back({row, first, last});
      }
      at = row * cols + last;
    }
  }
}

// Pixels of one row that have none of the region next to them in the other row.
void listUncovered(const Run* begin, const Run* end, const Run* other, const Run* other_end, int cols,
                   std::vector<int>& out) {
  for (const Run* run = begin; run != end; ++run) {
    int at = run->begin;
    while (other != other_end && other->end <= at) ++other;
    for (const Run* cover = other; at < run->end; ++cover) {
      const bool more = cover != other_end && cover->begin < run->end;
      for (const int stop = more ? cover->begin : run->end; at < stop; ++at) out.push_back(run->row * cols + at);
      if (!more) break;
      at = cover->end;
    }
  }
}

void listFringe(int cols, FringeMemory& memory) {
  for (std::vector<int>& side : memory.fringe) side.clear();
  const Run* const all_end = memory.runs.data() + memory.runs.size();
  const auto rowEnd = [all_end](const Run* run, int row) {
    while (run != all_end && run->row == row) ++run;
    return run;
  };
  const Run *above = memory.runs.data(), *above_end = above;
  for (const Run* begin = memory.runs.data(); begin != all_end;) {
    const int row = begin->row;
    const Run* const end = rowEnd(begin, row);
    const Run* const below_end = rowEnd(end, row + 1);
    const bool follows = above != above_end && above->row + 1 == row;
    listUncovered(begin, end, follows ? above : above_end, above_end, cols, memory.fringe[kAbove]);
    listUncovered(begin, end, end, below_end, cols, memory.fringe[kBelow]);
    for (const Run* run = begin; run != end; ++run) {
      memory.fringe[kBefore].push_back(row * cols + run->begin);
      memory.fringe[kAfter].push_back(row * cols + run->end - 1);
    }
    above = begin;
    above_end = begin = end;
  }
}

}  // namespace

const std::vector<PixelStretch>& offFringe(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end,
                                           const Plane& plane, double sigma, const ErrorScale& scale, FringeMemory& memory) {
  listRuns(begin, end, grid.cols, memory.runs);
  listFringe(grid.cols, memory);
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
    const std::size_t parts = (side.size() + kPart - 1) / kPart;
    for (std::size_t k = 0; k < parts; ++k) {
      const auto first = side.begin() + static_cast<std::ptrdiff_t>(side.size() * k / parts);
      const auto last = side.begin() + static_cast<std::ptrdiff_t>(side.size() * (k + 1) / parts);
      double sum = 0.0;
      for (auto i = first; i != last; ++i) sum += error(*i);
      if (std::abs(sum) > kSignificant * sigma * std::sqrt(static_cast<double>(last - first)))
        off.insert(off.end(), first, last);
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
