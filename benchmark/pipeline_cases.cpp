// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"
#include "patch_plane_clustering/core/stage_timer.h"

#include "cases.h"
#include "floor_cases.h"
#include "measure.h"
#include "workload.h"

#include <memory>
#include <string>

namespace ppc::bench {
namespace {

// What the nodelet keeps from one image to the next.
struct Memory {
  BeamColumns columns;
  BeamGrid grid;
  ClusteringMemory clustering;
  Segmentation segmentation;
};

// Adds the time of making the grid to the stages.
template <typename Make>
const BeamGrid& timedGrid(const Make& make, const Memory& memory, std::vector<StageTime>& stages) {
  StageTimer timer(&stages);
  make();
  timer.lap("grid");
  return memory.grid;
}

void segmentTimed(const BeamGrid& grid, Memory& memory, std::vector<StageTime>& stages, const Config& config = Config()) {
  Segmentation& segmentation = memory.segmentation;
  segment(grid, config, memory.clustering, segmentation);
  stages.insert(stages.end(), segmentation.stages.begin(), segmentation.stages.end());
  benchmark::DoNotOptimize(segmentation.polygons.data());
}

Frame labelsFrame(int points) {
  const RangeImage& image = officeImage(points);
  return [&image, memory = std::make_shared<Memory>()](std::vector<StageTime>& stages) {
    const BeamGrid& grid = timedGrid([&] { toBeamGrid(image, memory->columns, memory->grid); }, *memory, stages);
    LabelImage& labels = memory->segmentation.labels;
    clusterPatches(grid, Config(), memory->clustering, labels, &stages);
    benchmark::DoNotOptimize(labels.labels.data());
  };
}

Frame polygonsFrame(int points) {
  const RangeImage& image = officeImage(points);
  return [&image, memory = std::make_shared<Memory>()](std::vector<StageTime>& stages) {
    const BeamGrid& grid = timedGrid([&] { toBeamGrid(image, memory->columns, memory->grid); }, *memory, stages);
    segmentTimed(grid, *memory, stages);
  };
}

Frame threadsFrame(int threads) {
  const RangeImage& image = officeImage(kStandardPoints);
  Config config;
  config.threads = threads;
  return [&image, config, memory = std::make_shared<Memory>()](std::vector<StageTime>& stages) {
    const auto make = [&] { toBeamGrid(image, memory->columns, memory->grid, config.threads); };
    segmentTimed(timedGrid(make, *memory, stages), *memory, stages, config);
  };
}

Frame cloudFrame(int points) {
  const auto cloud = std::make_shared<const Cloud>(cloudOf(toBeamGrid(officeImage(points))));
  return [cloud, memory = std::make_shared<Memory>()](std::vector<StageTime>& stages) {
    const auto make = [&] {
      beamGridFromPoints(cloud->rows, cloud->cols, cloud->x, cloud->y, cloud->z, Eigen::Vector3f::Zero(), memory->grid);
    };
    segmentTimed(timedGrid(make, *memory, stages), *memory, stages);
  };
}

}  // namespace

void addPipeline() {
  addBenchmark("ppc/ranges to labels", kStandardPoints, {1.5}, [] { return labelsFrame(kStandardPoints); });
  addBenchmark("ppc/ranges to polygons", kStandardPoints, {1.5}, [] { return polygonsFrame(kStandardPoints); });
  addBenchmark("ppc/xyz to polygons", kStandardPoints, {1.5}, [] { return cloudFrame(kStandardPoints); });
}

void addSizes(int largest) {
  for (int points = 10000; points <= largest; points *= 10) {
    const std::string group = "size/" + std::to_string(points) + "/";
    addBenchmark(group + "floor", points, {0.3}, [points] { return floorFrame(points, true); });
    addBenchmark(group + "ranges to polygons", points, {1.0}, [points] { return polygonsFrame(points); });
  }
}

void addThreads() {
  for (const int threads : {1, 2, 4}) {
    addBenchmark("threads/" + std::to_string(threads), kStandardPoints, {2.0, 0, Clock::kWall},
                 [threads] { return threadsFrame(threads); });
  }
}

}  // namespace ppc::bench
