// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/patch_roughness.h"

#include "analytic_scenes.h"

#include <gtest/gtest.h>
#include <vector>

namespace ppc {
namespace {

using namespace testing_tools;

// One patch after the other, their number odd or even.
TEST(PatchRoughness, IsThatOfThePlaneThroughAPatchAndItsPlanarNeighbours) {
  BeamGrid grid = forwardBeams(20, 36, 0.01);
  scan({wall({-1.0, 0.0, 0.0}, -3.0)}, grid);
  addNoise(grid, 0.01);
  PatchGrid patches = makePatchGrid(grid, 4, false);
  const int count = static_cast<int>(patches.patches.size());
  for (int i = 0; i < count; ++i) patches.patches[i].planar = i % 5 != 0;
  for (const int end : {count, count - 1}) {
    std::vector<double> roughness(patches.patches.size(), -1.0);
    {
      PatchRoughness of(roughness);
      for (int i = 0; i < end; ++i) {
        if (patches.patches[i].planar) of.add(patches, i);
      }
    }
    for (int i = 0; i < count; ++i) {
      if (i >= end || !patches.patches[i].planar) {
        EXPECT_EQ(roughness[i], -1.0);
        continue;
      }
      Moments sum = patches.patches[i].moments;
      int planar = 0;
      patches.forEachNeighbour(i, [&](int j) {
        if (!patches.patches[j].planar) return;
        sum += patches.patches[j].moments;
        ++planar;
      });
      EXPECT_EQ(roughness[i], fitPlane(sum).chi2 / (sum.n - 3) + (4 - planar)) << i;
    }
  }
}

}  // namespace
}  // namespace ppc
