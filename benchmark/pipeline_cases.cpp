// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmenter.h"

#include "cases.h"
#include "floor_cases.h"
#include "measure.h"
#include "workload.h"

#include <chrono>
#include <memory>
#include <string>

namespace ppc::bench {
namespace {

// Adds the time of making the grid to the stages.
template <typename Make>
BeamGrid timedGrid(const Make& make, std::vector<StageTime>& stages) {
  const auto start = std::chrono::steady_clock::now();
  BeamGrid grid = make();
  stages.emplace_back("grid", std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  return grid;
}

void keepStages(Segmentation segmentation, std::vector<StageTime>& stages) {
  stages.insert(stages.end(), segmentation.stages.begin(), segmentation.stages.end());
  benchmark::DoNotOptimize(segmentation.polygons.data());
}

Frame labelsFrame(int points) {
  const RangeImage& image = officeImage(points);
  return [&image](std::vector<StageTime>& stages) {
    const BeamGrid grid = timedGrid([&] { return toBeamGrid(image); }, stages);
    LabelImage labels = clusterPatches(grid, Config(), &stages);
    benchmark::DoNotOptimize(labels.labels.data());
  };
}

Frame polygonsFrame(int points) {
  const RangeImage& image = officeImage(points);
  return [&image](std::vector<StageTime>& stages) {
    keepStages(segment(timedGrid([&] { return toBeamGrid(image); }, stages), Config()), stages);
  };
}

Frame cloudFrame(int points) {
  const auto cloud = std::make_shared<const Cloud>(cloudOf(toBeamGrid(officeImage(points))));
  return [cloud](std::vector<StageTime>& stages) {
    const auto make = [&] { return beamGridFromPoints(cloud->rows, cloud->cols, cloud->x, cloud->y, cloud->z); };
    keepStages(segment(timedGrid(make, stages), Config()), stages);
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

}  // namespace ppc::bench
