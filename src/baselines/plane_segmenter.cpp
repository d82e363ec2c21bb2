// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/baselines/plane_segmenter.h"

#include "methods.h"
#include "patch_plane_clustering/core/segmentation_memory.h"
#include "patch_plane_clustering/core/segmenter.h"

#include <sstream>
#include <stdexcept>

namespace ppc {
namespace {

class PatchPlaneClustering : public PlaneSegmenter {
 public:
  LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) override {
    LabelImage labels;
    clusterPatches(grid, config, memory_, labels, stages);
    return labels;
  }

  void segment(const BeamGrid& grid, const Config& config, Segmentation& result) override {
    ppc::segment(grid, config, memory_, result);
  }

 private:
  ClusteringMemory memory_;
};

}  // namespace

void PlaneSegmenter::segment(const BeamGrid& grid, const Config& config, Segmentation& result) {
  result.stages.clear();
  result.labels = label(grid, config, &result.stages);
  FinishingMemory memory;
  finishSegmentation(grid, smallestRegion(config, grid.size()), config, memory, result);
}

void PlaneSegmenter::setParameter(const std::string& name, double value) {
  std::string known;
  for (MethodParameter& each : parameters_) {
    known += (known.empty() ? "" : ", ") + each.name;
    if (each.name != name) continue;
    if (!(each.min <= value && value <= each.max)) {
      std::ostringstream message;
      message << "parameter '" << name << "' = " << value << " is not in [" << each.min << ", " << each.max << "]";
      throw std::invalid_argument(message.str());
    }
    each.value = value;
    return;
  }
  throw std::invalid_argument("unknown parameter '" + name + "' of this method; it has " + (known.empty() ? "none" : known));
}

double PlaneSegmenter::parameter(const std::string& name) const {
  for (const MethodParameter& each : parameters_) {
    if (each.name == name) return each.value;
  }
  throw std::logic_error("no parameter " + name);
}

const std::vector<std::string>& segmenterNames() {
  static const std::vector<std::string> names = {"ppc", "region_growing", "pcl_region_growing", "pcl_multi_plane", "ransac"};
  return names;
}

std::unique_ptr<PlaneSegmenter> makeSegmenter(const std::string& name) {
  if (name == "ppc") return std::make_unique<PatchPlaneClustering>();
  if (name == "region_growing") return makeRegionGrowing();
  if (name == "pcl_region_growing") return makePclRegionGrowing();
  if (name == "pcl_multi_plane") return makePclMultiPlane();
  if (name == "ransac") return makeRansac();
  std::string known;
  for (const auto& each : segmenterNames()) known += (known.empty() ? "" : ", ") + each;
  throw std::invalid_argument("unknown method '" + name + "'; known are " + known);
}

Segmentation segmentWith(PlaneSegmenter& method, const BeamGrid& grid, const Config& config) {
  Segmentation result;
  method.segment(grid, config, result);
  return result;
}

}  // namespace ppc
