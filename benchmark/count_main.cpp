// SPDX-License-Identifier: BSD-3-Clause
// One frame of each kind, for tools that count instructions by function: test/benchmark/test_instructions.py runs this under
// callgrind. Argument: points of the image.
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"

#include "floor.h"
#include "workload.h"

#include <cstdio>
#include <cstdlib>

// Found by these names: not inlined, not mangled.
extern "C" {

__attribute__((noinline)) void countedFloor(const ppc::RangeImage& image, const ppc::bench::FloorGeometry& geometry,
                                            ppc::bench::FloorSums& sums, ppc::bench::FloorPlanes& planes) {
  ppc::bench::sumPatches(image.ranges, geometry, sums);
  ppc::bench::fitPatches(sums, planes);
}

__attribute__((noinline)) void countedGrid(const ppc::RangeImage& image, ppc::BeamColumns& columns, ppc::BeamGrid& grid) {
  ppc::toBeamGrid(image, columns, grid);
}

__attribute__((noinline)) void countedSegmentation(const ppc::BeamGrid& grid, ppc::ClusteringMemory& memory,
                                                   ppc::Segmentation& segmentation) {
  ppc::segment(grid, ppc::Config(), memory, segmentation);
}

// The same with memory as another frame has left it, as it is on a robot.
__attribute__((noinline)) void countedNextSegmentation(const ppc::BeamGrid& grid, ppc::ClusteringMemory& memory,
                                                       ppc::Segmentation& segmentation) {
  ppc::segment(grid, ppc::Config(), memory, segmentation);
}
}

int main(int argc, char** argv) {
  const ppc::RangeImage& image = ppc::bench::officeImage(argc > 1 ? std::atoi(argv[1]) : ppc::bench::kStandardPoints);
  const ppc::bench::FloorGeometry geometry = ppc::bench::floorGeometry(image);
  ppc::bench::FloorSums sums;
  ppc::bench::FloorPlanes planes;
  countedFloor(image, geometry, sums, planes);
  ppc::BeamColumns columns;
  ppc::BeamGrid grid;
  countedGrid(image, columns, grid);
  ppc::Segmentation segmentation;
  ppc::ClusteringMemory memory;
  countedSegmentation(grid, memory, segmentation);
  countedNextSegmentation(grid, memory, segmentation);
  std::printf("%d x %d, %zu patches of the floor, %zu regions, %zu polygons\n", image.rows, image.cols, planes.d.size(),
              segmentation.regions.size(), segmentation.polygons.size());
  return 0;
}
