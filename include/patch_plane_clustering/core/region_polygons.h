// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <vector>

namespace ppc {

struct PolygonMemory;  // see polygon_memory.h

struct PolygonOptions {
  double simplification_tolerance = 0.02;  ///< largest distance between the outline and its simplification [m]; 0 = keep all
  double pixel_tolerance =
      1.0;                    ///< the same in pixels, across the edge; the larger of the two applies. Removes the staircase
                              ///< of the pixels, which is no edge of the scene; 0 = the tolerance in metres alone
  int min_hole_size = 20;     ///< holes of fewer pixels than this are filled, detached specks of fewer left out
  bool snap_creases = false;  ///< vertices along the common line of two neighbouring planes are moved onto it
};

/// @brief Outlines of the labelled regions as polygons with holes on their planes.
///
/// The outline runs along pixel corners (through centres it would lose half a pixel a side); the beam through each corner is
/// cut with the plane, so edges carry no range noise. Every polygon returned is simple, its holes lie inside, do not
/// overlap, and the number of vertices is reduced within the tolerance. A region in several 4-connected parts, or one that
/// no simple ring can bound (it reaches round the pole of the scan), comes as several polygons of the same id. Loops in
/// which noise made an outline cross itself are cut off if they enclose next to nothing. A region seen edge-on, whose beams
/// do not tell where on the plane its outline runs, gets the convex hull of its points where its outline is not simple.
/// Parts that collapse to nothing are left out. All coordinates are finite and on the plane, whatever the beams.
/// Deterministic, thread-safe.
/// @param regions as made by describeRegions() from the same labels.
/// @return polygons in ascending id, larger pieces first.
/// @throws std::invalid_argument if the labels do not fit the grid.
std::vector<PlanarPolygon> extractPolygons(const BeamGrid& grid, const LabelImage& labels,
                                           const std::vector<PlanarRegion>& regions, const PolygonOptions& options,
                                           int threads = 1);

/// @brief The same with memory. @param runs of the labels. @param polygons overwritten; what it holds is used again, too.
void extractPolygons(const BeamGrid& grid, const LabelImage& labels, const std::vector<LabelRun>& runs,
                     const std::vector<PlanarRegion>& regions, const PolygonOptions& options, PolygonMemory& memory,
                     std::vector<PlanarPolygon>& polygons, int threads = 1);

/// @brief Its first half, which needs no planes: outlines of the labelled pixels, left in the memory.
void traceOutlines(const LabelImage& labels, const std::vector<LabelRun>& runs, const PolygonOptions& options,
                   PolygonMemory& memory);

/// @brief Its second half. @param memory with the outlines of `labels`, which fit the grid. @param polygons as above.
void makePolygons(const BeamGrid& grid, const LabelImage& labels, const std::vector<PlanarRegion>& regions,
                  const PolygonOptions& options, PolygonMemory& memory, std::vector<PlanarPolygon>& polygons,
                  int threads = 1);

}  // namespace ppc
