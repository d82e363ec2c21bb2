// SPDX-License-Identifier: BSD-3-Clause
// An image as one region, cell by cell, shared by the tests of cuts and divisions.
#pragma once

#include "patch_plane_clustering/core/clustering.h"
#include "patch_plane_clustering/core/patch_grid.h"
#include "patch_plane_clustering/core/surface_cut.h"

#include "analytic_scenes.h"

#include <vector>

namespace ppc::testing_tools {

/// All cells of an image, measured against the plane of them all.
struct SurfaceRegion {
  BeamGrid grid;
  LabelImage truth;
  PatchGrid cells;
  Moments all;
  std::vector<SurfaceCell> surface;

  /// @param beams without ranges.
  SurfaceRegion(const std::vector<Surface>& surfaces, const BeamGrid& beams) : grid(beams) {
    truth = scan(surfaces, grid);
    addNoise(grid, 0.01);
    cells = makePatchGrid(grid, 4, true);
    weighPatches(NoiseModel(SensorModel{0.01, 0.01, 10.0, 0.0}, 1.0), cells);
    for (const Patch& cell : cells.patches) all += cell.moments;
    const SurfaceFrame frame(all, fitPlane(all));
    for (const Patch& cell : cells.patches) surface.push_back({xOf(cell), yOf(cell), frame.measure(cell.moments)});
  }

  static float xOf(const Patch& cell) { return static_cast<float>(cell.col_begin); }
  static float yOf(const Patch& cell) { return static_cast<float>(cell.row_begin); }
};

}  // namespace ppc::testing_tools
