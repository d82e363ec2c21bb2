// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace ppc::bench {

/// Four floats side by side: one register of SSE2 or NEON, by the vector extension of GCC and Clang.
constexpr int kLanes = 4;
using Lanes = float __attribute__((vector_size(4 * kLanes)));
using LaneMask = std::int32_t __attribute__((vector_size(4 * kLanes)));  ///< -1 or 0 a lane, as comparisons give it

inline Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

inline void store(float* to, const Lanes& lanes) { std::memcpy(to, &lanes, sizeof(lanes)); }

/// The lanes of the mask, 0 in the others, also where they hold NaN.
inline Lanes keep(const LaneMask& mask, const Lanes& lanes) {
  return reinterpret_cast<Lanes>(mask & reinterpret_cast<LaneMask>(lanes));
}

inline Lanes select(const LaneMask& mask, const Lanes& yes, const Lanes& no) { return mask ? yes : no; }

inline Lanes squareRoot(const Lanes& lanes) {
  return Lanes{std::sqrt(lanes[0]), std::sqrt(lanes[1]), std::sqrt(lanes[2]), std::sqrt(lanes[3])};
}

inline float sum(const Lanes& lanes) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }

}  // namespace ppc::bench
