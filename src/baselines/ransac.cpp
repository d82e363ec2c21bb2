// SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"
#include "patch_plane_clustering/core/quantile.h"
#include "patch_plane_clustering/core/stage_timer.h"
#include "pcl_cloud.h"

#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <cmath>

namespace ppc {
namespace {

constexpr std::size_t kSample = 12000;  // planes are sought in so many of the points that are left
constexpr int kFailures = 8;            // planes in a row without a part that is large enough

// Labels the parts of `pixels` that are connected in the image (8 neighbours) and large enough; all leave the pool.
int labelParts(const BeamGrid& grid, const std::vector<int>& pixels, int min_size, std::vector<char>& in_pool,
               std::int32_t& label, LabelImage& labels) {
  std::vector<char> open(labels.labels.size(), 0);
  for (const int i : pixels) open[i] = 1;
  int parts = 0;
  std::vector<int> part;
  for (const int first : pixels) {
    if (open[first] == 0) continue;
    part.assign(1, first);
    open[first] = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const int row = part[k] / grid.cols, col = part[k] % grid.cols;
      for (int r = std::max(0, row - 1); r <= std::min(grid.rows - 1, row + 1); ++r) {
        for (int c = std::max(0, col - 1); c <= std::min(grid.cols - 1, col + 1); ++c) {
          const int j = grid.index(r, c);
          if (open[j] == 0) continue;
          open[j] = 0;
          part.push_back(j);
        }
      }
    }
    if (static_cast<int>(part.size()) < min_size) continue;
    ++parts;
    ++label;
    for (const int i : part) {
      labels.labels[i] = label;
      in_pool[i] = 0;
    }
  }
  return parts;
}

class Ransac : public PlaneSegmenter {
 public:
  // Defaults: the best at the data sheet's noise in scripts/tune_baselines.py.
  Ransac()
      : PlaneSegmenter({{"distance", 2.0, 0.1, 100.0, "largest distance of an inlier from the plane [sigmas]"},
                        {"iterations", 400, 1, 100000, "samples drawn for a plane [1]"}}) {}

  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    StageTimer timer(stages);
    const NoiseModel noise = noiseOf(grid, config);
    const auto cloud = toPclCloud(grid);
    LabelImage labels = noLabels(grid);
    std::vector<char> in_pool(labels.labels.size(), 0);
    std::vector<double> sigmas(labels.labels.size(), 0.0);
    std::vector<int> pool = validPixels(grid);
    for (const int i : pool) {
      in_pool[i] = 1;
      sigmas[i] = std::hypot(noise.sigma(grid.range[i]), config.sigma_distance);
    }
    std::int32_t label = 0;
    const double distance = parameter("distance");
    const int min_size = smallestRegion(config, grid.size());
    for (int failures = 0; failures < kFailures && static_cast<int>(pool.size()) >= min_size;) {
      const Plane plane = bestPlane(cloud, pool, sigmas);
      std::vector<int> inliers;
      for (const int i : pool) {
        if (std::abs(plane.signedDistance(grid.point(i).cast<double>())) < distance * sigmas[i]) inliers.push_back(i);
      }
      const int parts = labelParts(grid, inliers, min_size, in_pool, label, labels);
      failures = parts > 0 ? 0 : failures + 1;
      if (parts == 0) {  // do not find the same plane again
        for (const int i : inliers) in_pool[i] = 0;
      }
      pool.erase(std::remove_if(pool.begin(), pool.end(), [&](int i) { return in_pool[i] == 0; }), pool.end());
      if (inliers.empty()) break;
    }
    timer.lap("ransac");
    return labels;
  }

 private:
  Plane bestPlane(const pcl::PointCloud<pcl::PointXYZ>::Ptr& cloud, const std::vector<int>& pool,
                  const std::vector<double>& sigmas) const {
    pcl::PointIndices::Ptr sample(new pcl::PointIndices);
    const std::size_t step = std::max<std::size_t>(1, pool.size() / kSample);
    std::vector<double> spread;
    for (std::size_t i = 0; i < pool.size(); i += step) {
      sample->indices.push_back(pool[i]);
      spread.push_back(sigmas[pool[i]]);
    }
    pcl::SACSegmentation<pcl::PointXYZ> ransac;  // not `random`: its seed is fixed
    ransac.setModelType(pcl::SACMODEL_PLANE);
    ransac.setMethodType(pcl::SAC_RANSAC);
    ransac.setDistanceThreshold(parameter("distance") * median(spread));
    ransac.setMaxIterations(static_cast<int>(parameter("iterations")));
    ransac.setOptimizeCoefficients(true);
    ransac.setInputCloud(cloud);
    ransac.setIndices(sample);
    pcl::ModelCoefficients coefficients;
    pcl::PointIndices inliers;
    ransac.segment(inliers, coefficients);
    Plane plane;
    if (coefficients.values.size() < 4) return {Eigen::Vector3d::UnitZ(), std::numeric_limits<double>::quiet_NaN()};
    plane.normal = Eigen::Vector3d(coefficients.values[0], coefficients.values[1], coefficients.values[2]);
    plane.d = -coefficients.values[3] / plane.normal.norm();
    plane.normal.normalize();
    return plane;
  }
};

}  // namespace

std::unique_ptr<PlaneSegmenter> makeRansac() { return std::make_unique<Ransac>(); }

}  // namespace ppc
