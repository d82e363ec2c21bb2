// SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"
#include "patch_plane_clustering/core/stage_timer.h"
#include "pcl_cloud.h"

#include <pcl/segmentation/organized_multi_plane_segmentation.h>

#include <algorithm>

namespace ppc {
namespace {

class PclMultiPlane : public PlaneSegmenter {
 public:
  // Defaults: the best at the data sheet's noise in scripts/tune_baselines.py.
  PclMultiPlane()
      : PlaneSegmenter({{"half_window", 12, 1, 50, "half the width of the window of a normal [columns]"},
                        {"angle", 0.04, 0.001, 1.6, "between the normals of neighbours [rad]"},
                        {"distance", 2.0, 0.1, 100.0, "between the planes of neighbours [sigmas at the median range]"},
                        {"curvature", 0.01, 0.0001, 0.34, "largest of a region [1]"}}) {}

  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    StageTimer timer(stages);
    const NoiseModel noise = noiseOf(grid, config);
    const auto cloud = toPclCloud(grid);
    const auto normals =
        toPclNormals(grid, localPlanes(grid, noise, windowOf(grid, static_cast<int>(parameter("half_window")))));
    timer.lap("normals");

    LabelImage image = noLabels(grid);
    std::vector<int> pixels = validPixels(grid);
    const int min_size = smallestRegion(config, grid.size());
    if (static_cast<int>(pixels.size()) < min_size || grid.rows < 3 || grid.cols < 3) return image;
    const auto middle = pixels.begin() + static_cast<std::ptrdiff_t>(pixels.size() / 2);
    std::nth_element(pixels.begin(), middle, pixels.end(), [&](int a, int b) { return grid.range[a] < grid.range[b]; });

    pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> planes;
    planes.setInputCloud(cloud);
    planes.setInputNormals(normals);
    planes.setMinInliers(static_cast<unsigned>(min_size));
    planes.setAngularThreshold(parameter("angle"));
    planes.setDistanceThreshold(parameter("distance") * noise.sigma(grid.range[*middle]));
    planes.setMaximumCurvature(parameter("curvature"));
    std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>> regions;
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers, label_indices, boundaries;
    pcl::PointCloud<pcl::Label>::Ptr labels(new pcl::PointCloud<pcl::Label>);
    planes.segmentAndRefine(regions, coefficients, inliers, labels, label_indices, boundaries);
    std::int32_t label = 0;
    for (const auto& region : inliers) {
      ++label;
      for (const int i : region.indices) image.labels[i] = label;
    }
    timer.lap("planes");
    return image;
  }
};

}  // namespace

std::unique_ptr<PlaneSegmenter> makePclMultiPlane() { return std::make_unique<PclMultiPlane>(); }

}  // namespace ppc
