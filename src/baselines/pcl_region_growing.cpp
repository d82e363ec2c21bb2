// SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"
#include "pcl_cloud.h"
#include "stage_timer.h"

#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include <limits>

namespace ppc {
namespace {

// Chosen by hand, looking at simulated offices and stairs; not yet searched systematically.
constexpr int kHalfWindow = 5;        // of the normals [columns]
constexpr unsigned kNeighbours = 20;  // of a point that a region may grow to
constexpr float kSmoothness = 0.06F;  // largest angle between the normals of neighbours [rad]
constexpr float kCurvature = 0.05F;   // a point of higher curvature does not grow on

class PclRegionGrowing : public PlaneSegmenter {
 public:
  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    StageTimer timer(stages);
    const NoiseModel noise = noiseOf(grid, config);
    const auto cloud = toPclCloud(grid);
    const auto normals = toPclNormals(grid, localPlanes(grid, noise, windowOf(grid, kHalfWindow)));
    timer.lap("normals");

    LabelImage labels = noLabels(grid);
    // PCL's kd-tree wants finite points only, so the valid ones are copied out.
    const std::vector<int> pixels = validPixels(grid);
    if (static_cast<int>(pixels.size()) < config.min_size) return labels;
    pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>(*cloud, pixels));
    pcl::PointCloud<pcl::Normal>::Ptr point_normals(new pcl::PointCloud<pcl::Normal>(*normals, pixels));
    pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
    pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
    growing.setMinClusterSize(config.min_size);
    growing.setMaxClusterSize(std::numeric_limits<int>::max());
    growing.setSearchMethod(tree);
    growing.setNumberOfNeighbours(kNeighbours);
    growing.setInputCloud(points);
    growing.setInputNormals(point_normals);
    growing.setSmoothnessThreshold(kSmoothness);
    growing.setCurvatureThreshold(kCurvature);
    std::vector<pcl::PointIndices> clusters;
    growing.extract(clusters);
    std::int32_t label = 0;
    for (const auto& cluster : clusters) {
      ++label;
      for (const int i : cluster.indices) labels.labels[pixels[i]] = label;
    }
    timer.lap("growing");
    return labels;
  }
};

}  // namespace

std::unique_ptr<PlaneSegmenter> makePclRegionGrowing() { return std::make_unique<PclRegionGrowing>(); }

}  // namespace ppc
