// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"

namespace ppc {

/// @brief Sums of points and of their products, lane by lane: of some hundred points about one of them at most, for single
/// precision to suffice.
struct PointLanes {
  Lanes x = {}, y = {}, z = {}, xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {};

  void add(Lanes px, Lanes py, Lanes pz) {
    x += px;
    y += py;
    z += pz;
    xx += px * px;
    xy += px * py;
    xz += px * pz;
    yy += py * py;
    yz += py * pz;
    zz += pz * pz;
  }
};

}  // namespace ppc
