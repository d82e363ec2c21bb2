// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/grid_lines.h"

#include <algorithm>

namespace ppc {
namespace {

constexpr int kReach = 6;   // lines to either side: few enough for a plane, enough for errors of tilt to matter little
constexpr int kBeams = 16;  // that are looked at for the one that moves most

}  // namespace

GridLines::Span GridLines::spanAround(int line) const {
  Span span{std::max(0, line - kReach), std::min(count_ - 1, line + kReach), 0.0};
  const int stride = std::max(1, beams_ / kBeams);
  for (int beam = 0; beam < beams_; beam += stride) {
    span.angle = std::max(span.angle, static_cast<double>(chord(span, beam).norm()));
  }
  return span;
}

}  // namespace ppc
