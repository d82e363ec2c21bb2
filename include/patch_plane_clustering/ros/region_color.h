// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace ppc {

/// @brief A colour, 8 bits a channel.
struct RegionColor {
  std::uint8_t r = 0, g = 0, b = 0;
};

/// @brief Colour of a region: the same for the same id, far apart in hue for ids that follow each other; grey for id 0
/// (none).
RegionColor regionColor(std::int32_t id);

}  // namespace ppc
