// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/region_color.h"

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

std::uint8_t channel(double hue, double saturation, double value) {
  const double triangle = std::clamp(std::abs(hue - 3.0) - 1.0, 0.0, 1.0);  // of the red channel; hue 0..6
  return static_cast<std::uint8_t>(std::lround(255.0 * value * (1.0 - saturation * (1.0 - triangle))));
}

}  // namespace

RegionColor regionColor(std::int32_t id) {
  if (id <= 0) return {110, 110, 110};
  constexpr double kGoldenRatio = 0.61803398874989485;  // steps of it never come close to an earlier hue for long
  const double hue = 6.0 * std::fmod(kGoldenRatio * id, 1.0);
  const double saturation = 0.55 + 0.4 * (id % 3) / 2.0;
  const double value = 1.0 - 0.3 * (id % 4) / 3.0;
  return {channel(hue, saturation, value), channel(std::fmod(hue + 4.0, 6.0), saturation, value),
          channel(std::fmod(hue + 2.0, 6.0), saturation, value)};
}

}  // namespace ppc
