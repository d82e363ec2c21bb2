// SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"
#include "patch_plane_clustering/core/stage_timer.h"
#include "pcl_cloud.h"

#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include <limits>

namespace ppc {
namespace {

class PclRegionGrowing : public PlaneSegmenter {
 public:
  // Defaults: the best at the data sheet's noise in scripts/tune_baselines.py.
  PclRegionGrowing()
      : PlaneSegmenter({{"half_window", 10, 1, 50, "half the width of the window of a normal [columns]"},
                        {"neighbours", 20, 3, 200, "of a point that a region may grow to [points]"},
                        {"smoothness", 0.1, 0.001, 1.6, "largest angle between the normals of neighbours [rad]"},
                        {"curvature", 0.05, 0.0001, 0.34, "a point of higher curvature does not grow on [1]"}}) {}

  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    StageTimer timer(stages);
    const NoiseModel noise = noiseOf(grid, config);
    const auto cloud = toPclCloud(grid);
    const auto normals =
        toPclNormals(grid, localPlanes(grid, noise, windowOf(grid, static_cast<int>(parameter("half_window")))));
    timer.lap("normals");

    LabelImage labels = noLabels(grid);
    // PCL's kd-tree wants finite points only, so the valid ones are copied out.
    const std::vector<int> pixels = validPixels(grid);
    const int min_size = smallestRegion(config, grid.size());
    if (static_cast<int>(pixels.size()) < min_size) return labels;
    pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>(*cloud, pixels));
    pcl::PointCloud<pcl::Normal>::Ptr point_normals(new pcl::PointCloud<pcl::Normal>(*normals, pixels));
    pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
    pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
    growing.setMinClusterSize(min_size);
    growing.setMaxClusterSize(std::numeric_limits<int>::max());
    growing.setSearchMethod(tree);
    growing.setNumberOfNeighbours(static_cast<unsigned>(parameter("neighbours")));
    growing.setInputCloud(points);
    growing.setInputNormals(point_normals);
    growing.setSmoothnessThreshold(static_cast<float>(parameter("smoothness")));
    growing.setCurvatureThreshold(static_cast<float>(parameter("curvature")));
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
