// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"
#include "patch_plane_clustering/ros/markers.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include "cases.h"
#include "measure.h"
#include "workload.h"

#include <functional>
#include <memory>

namespace ppc::bench {
namespace {

// What the nodelet has in its hands once it has segmented an image.
struct Segmented {
  RangeImageMsg message;
  sensor_msgs::PointCloud2 cloud;
  BeamGrid grid;
  Segmentation segmentation;
};

std::shared_ptr<const Segmented> segmented() {
  auto s = std::make_shared<Segmented>();
  s->message = toMessage(officeImage(), std_msgs::Header());
  s->cloud = toPointCloud(officeImage(), std_msgs::Header());
  s->grid = toBeamGrid(officeImage());
  s->segmentation = segment(s->grid, Config());
  return s;
}

void add(const std::string& name, std::function<void(const Segmented&, std::vector<StageTime>&)> work) {
  addBenchmark("message/" + name, kStandardPoints, {1.0}, [work = std::move(work)]() -> Frame {
    const auto s = segmented();
    return [s, work](std::vector<StageTime>& stages) {
      work(*s, stages);
      benchmark::ClobberMemory();
    };
  });
}

template <typename Make>
void addConversion(const std::string& name, const Make& make) {
  add(name, [make](const Segmented& s, std::vector<StageTime>&) {
    auto made = make(s);
    benchmark::DoNotOptimize(&made);
  });
}

}  // namespace

void addMessages() {
  add("range image in, polygons out", [](const Segmented& s, std::vector<StageTime>& stages) {
    static RangeImage image;  // the nodelet keeps all of these, too
    static BeamColumns columns;
    static BeamGrid grid;
    static ClusteringMemory memory;
    static Segmentation segmentation;
    fromMessage(s.message, image);
    toBeamGrid(image, columns, grid);
    segment(grid, Config(), memory, segmentation);
    const PlanarPolygonArray polygons = toPolygonArray(segmentation, s.message.header);
    benchmark::DoNotOptimize(polygons.polygons.data());
    stages.insert(stages.end(), segmentation.stages.begin(), segmentation.stages.end());
  });
  add("range image to grid", [](const Segmented& s, std::vector<StageTime>&) {
    static RangeImage image;
    static BeamColumns columns;
    static BeamGrid grid;
    fromMessage(s.message, image);
    toBeamGrid(image, columns, grid);
  });
  add("point cloud to grid", [](const Segmented& s, std::vector<StageTime>&) {
    static CloudCoordinates coordinates;
    static BeamGrid grid;
    gridFromCloud(s.cloud, coordinates, grid);
  });
  addConversion("polygons", [](const Segmented& s) { return toPolygonArray(s.segmentation, s.message.header); });
  addConversion("statistics", [](const Segmented& s) { return toStatistics(s.segmentation, s.message.header); });
  addConversion("labels", [](const Segmented& s) { return toLabelImage(s.segmentation.labels, s.message.header); });
  addConversion("markers", [](const Segmented& s) { return toMarkers(s.segmentation, s.message.header); });
  addConversion("segmented points",
                [](const Segmented& s) { return toSegmentedCloud(s.grid, s.segmentation.labels, s.message.header); });
}

}  // namespace ppc::bench
