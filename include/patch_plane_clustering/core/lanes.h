// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace ppc {

/// @file Four pixels of a row at a time, in the vector registers that every x86-64 and arm64 processor has (a vector
/// extension that GCC and Clang share). Comparisons give masks; `mask ? a : b` chooses lane by lane.
constexpr int kLanes = 4;
using Lanes = float __attribute__((vector_size(16)));
using LaneMask = std::int32_t __attribute__((vector_size(16)));  ///< per lane 0 or -1 (all bits)

inline Lanes fill(float value) { return Lanes{value, value, value, value}; }
inline LaneMask fillMask(std::int32_t value) { return LaneMask{value, value, value, value}; }

/// The first `count` of four lanes.
inline LaneMask firstLanes(int count) { return LaneMask{0, 1, 2, 3} < fillMask(count); }

/// Reads four numbers.
template <typename Vector, typename Number>
Vector loadLanes(const Number* data) {
  static_assert(sizeof(Number) == 4, "lanes are four bytes wide");
  Vector lanes;
  std::memcpy(&lanes, data, sizeof lanes);
  return lanes;
}

/// Reads the first `count` (0 to 4) of four numbers; the other lanes are 0.
template <typename Vector, typename Number>
Vector loadLanes(const Number* data, int count) {
  static_assert(sizeof(Number) == 4, "lanes are four bytes wide");
  Vector lanes{};
  std::memcpy(&lanes, data, sizeof(Number) * static_cast<std::size_t>(std::min(count, kLanes)));
  return lanes;
}

/// Writes four numbers.
inline void storeLanes(Lanes lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); }

inline float sumLanes(Lanes v) { return (v[0] + v[2]) + (v[1] + v[3]); }
/// Two numbers of double precision.
constexpr int kPair = 2;
using Pair = double __attribute__((vector_size(16)));

/// sumLanes() of four vectors at a time, lane by lane.
template <typename Vector>
Vector sumLanes(Vector a, Vector b, Vector c, Vector d) {
  const Vector ab = __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
  const Vector cd = __builtin_shufflevector(c, d, 0, 1, 4, 5) + __builtin_shufflevector(c, d, 2, 3, 6, 7);
  return __builtin_shufflevector(ab, cd, 0, 2, 4, 6) + __builtin_shufflevector(ab, cd, 1, 3, 5, 7);
}

/// The first two lanes, and the last two.
inline Pair firstPair(Lanes v) { return Pair{v[0], v[1]}; }
inline Pair lastPair(Lanes v) { return Pair{v[2], v[3]}; }

inline int countLanes(LaneMask m) { return -((m[0] + m[2]) + (m[1] + m[3])); }
inline bool anyLane(LaneMask m) {
  std::int64_t halves[2];
  std::memcpy(halves, &m, sizeof halves);
  return (halves[0] | halves[1]) != 0;
}

/// @brief Up to four neighbouring beams of a row.
struct BeamLanes {
  Lanes dir_x, dir_y, dir_z, range;
  Lanes origin_x = {}, origin_y = {}, origin_z = {};
  LaneMask valid;  ///< has a measurement, and lies within `count`

  // cppcheck-suppress uninitMemberVar
  BeamLanes() = default;  ///< to be assigned

  /// The four from pixel i on, all of which lie in the grid.
  BeamLanes(const BeamGrid& grid, int i) {
    read(grid, i, [](const float* from) { return loadLanes<Lanes>(from); });
    valid = range > Lanes{};
  }

  /// The first `count` of them.
  BeamLanes(const BeamGrid& grid, int i, int count) {
    if (i + kLanes <= grid.size()) {
      read(grid, i, [](const float* from) { return loadLanes<Lanes>(from); });
    } else {  // nothing beyond the last pixel may be touched
      const int rest = grid.size() - i;
      read(grid, i, [rest](const float* from) { return loadLanes<Lanes>(from, rest); });
    }
    valid = (range > Lanes{}) & firstLanes(count);
  }

  /// Four beams anywhere, those of which count that are `inside`.
  BeamLanes(const BeamGrid& grid, const int (&pixels)[kLanes], LaneMask inside) {
    const auto gather = [&pixels](const std::vector<float>& from) {
      return Lanes{from[pixels[0]], from[pixels[1]], from[pixels[2]], from[pixels[3]]};
    };
    range = gather(grid.range);
    dir_x = gather(grid.dir_x);
    dir_y = gather(grid.dir_y);
    dir_z = gather(grid.dir_z);
    if (!grid.origin_x.empty()) {
      origin_x = gather(grid.origin_x);
      origin_y = gather(grid.origin_y);
      origin_z = gather(grid.origin_z);
    }
    valid = (range > Lanes{}) & inside;
  }

 private:
  template <typename Load>
  void read(const BeamGrid& grid, int i, Load&& load) {
    range = load(grid.range.data() + i);
    dir_x = load(grid.dir_x.data() + i);
    dir_y = load(grid.dir_y.data() + i);
    dir_z = load(grid.dir_z.data() + i);
    if (grid.origin_x.empty()) return;
    origin_x = load(grid.origin_x.data() + i);
    origin_y = load(grid.origin_y.data() + i);
    origin_z = load(grid.origin_z.data() + i);
  }
};

}  // namespace ppc
