// SPDX-License-Identifier: BSD-3-Clause
#include "floor_cases.h"

#include "cases.h"
#include "floor.h"
#include "measure.h"
#include "workload.h"

#include <cstring>
#include <memory>

namespace ppc::bench {
namespace {

Frame copyFrame(int points) {
  const RangeImage& image = officeImage(points);
  auto copy = std::make_shared<std::vector<float>>(image.ranges.size());
  return [&image, copy](std::vector<StageTime>&) {
    std::memcpy(copy->data(), image.ranges.data(), image.ranges.size() * sizeof(float));
    benchmark::DoNotOptimize(copy->data());
    benchmark::ClobberMemory();
  };
}

}  // namespace

Frame floorFrame(int points, bool fit) {
  struct Scratch {
    FloorGeometry geometry;
    FloorSums sums;
    FloorPlanes planes;
  };
  const RangeImage& image = officeImage(points);
  auto scratch = std::make_shared<Scratch>();
  scratch->geometry = floorGeometry(image);
  return [&image, scratch, fit](std::vector<StageTime>&) {
    sumPatches(image.ranges, scratch->geometry, scratch->sums);
    if (fit) fitPatches(scratch->sums, scratch->planes);
    benchmark::DoNotOptimize(scratch->sums.zz.data());
    benchmark::DoNotOptimize(scratch->planes.d.data());
    benchmark::ClobberMemory();
  };
}

void addFloor() {
  addBenchmark("floor/copy", kStandardPoints, {0.3}, [] { return copyFrame(kStandardPoints); });
  addBenchmark("floor/moments", kStandardPoints, {0.5}, [] { return floorFrame(kStandardPoints, false); });
  addBenchmark("floor/fits", kStandardPoints, {0.5}, [] { return floorFrame(kStandardPoints, true); });
}

}  // namespace ppc::bench
