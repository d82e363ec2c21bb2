// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/patch_grid.h"

#include <algorithm>
#include <vector>

namespace ppc {

/// @brief Two sums of moments side by side, for solvePlane().
struct MomentsPair {
  Pair xx, xy, xz, yy, yz, zz, x, y, z, w;

  MomentsPair(const Moments& a, const Moments& b)
      : xx{a.xx, b.xx},
        xy{a.xy, b.xy},
        xz{a.xz, b.xz},
        yy{a.yy, b.yy},
        yz{a.yz, b.yz},
        zz{a.zz, b.zz},
        x{a.x, b.x},
        y{a.y, b.y},
        z{a.z, b.z},
        w{a.w, b.w} {}
};

/// @brief How rough the surroundings of patches are: chi-square of one plane through a patch and its planar neighbours, over
/// its degrees of freedom, and one for each of four neighbours that is missing. Two patches at a time, so that the divisions
/// of one are not waited for.
class PatchRoughness {
 public:
  /// @param of for every patch; what is measured is there once this is gone.
  explicit PatchRoughness(std::vector<double>& of) : of_(of) {}
  PatchRoughness(const PatchRoughness&) = delete;
  PatchRoughness& operator=(const PatchRoughness&) = delete;
  ~PatchRoughness() {
    if (count_ > 0) measure();
  }

  /// Takes the planar patch i.
  void add(const PatchGrid& grid, int i) {
    Moments around = grid.patches[i].moments;
    int missing = 4;
    grid.forEachNeighbour(i, [&](int j) {
      if (!grid.patches[j].planar) return;
      around += grid.patches[j].moments;
      --missing;
    });
    around_[count_] = around;
    missing_[count_] = std::max(0, missing);
    index_[count_] = i;
    if (++count_ == kPair) measure();
  }

 private:
  void measure() {
    const Pair chi2 = solvePlane<Pair>(MomentsPair(around_[0], around_[1])).chi2;
    for (int k = 0; k < count_; ++k) of_[index_[k]] = chi2[k] / std::max(1, around_[k].n - 3) + missing_[k];
    count_ = 0;
  }

  std::vector<double>& of_;
  Moments around_[kPair];
  int missing_[kPair] = {}, index_[kPair] = {};
  int count_ = 0;
};

}  // namespace ppc
