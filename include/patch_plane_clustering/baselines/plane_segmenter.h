// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/config.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <memory>
#include <string>
#include <vector>

namespace ppc {

/// @brief A parameter that one method has for itself, beyond Config.
struct MethodParameter {
  std::string name;
  double value = 0.0;
  double min = 0.0, max = 0.0;
  std::string description;  ///< ends with the unit in brackets
};

/// @brief A method that labels the planar regions of a grid of beams. PPC and the methods it is compared with share it.
class PlaneSegmenter {
 public:
  virtual ~PlaneSegmenter() = default;

  /// Labels 1..N in any order, 0 = none. Stage times are appended if asked for. Not thread-safe on one object.
  virtual LabelImage label(const BeamGrid& grid, const Config& config, std::vector<StageTime>* stages) = 0;

  /// Labels, then region statistics and polygons (finishSegmentation). @param result overwritten; its memory is used again.
  virtual void segment(const BeamGrid& grid, const Config& config, Segmentation& result);

  /// Parameters of the method's own; PPC has none, all of its are in Config.
  const std::vector<MethodParameter>& parameters() const { return parameters_; }

  /// Changes one. @throws std::invalid_argument naming the parameter, the value and what is allowed.
  void setParameter(const std::string& name, double value);

 protected:
  PlaneSegmenter() = default;
  explicit PlaneSegmenter(std::vector<MethodParameter> parameters) : parameters_(std::move(parameters)) {}
  /// Value of a parameter. Precondition: there is one of that name.
  double parameter(const std::string& name) const;

 private:
  std::vector<MethodParameter> parameters_;
};

/// @brief Names of all methods: ppc, region_growing, pcl_region_growing, pcl_multi_plane, ransac.
const std::vector<std::string>& segmenterNames();

/// @brief Makes a method by name. @throws std::invalid_argument listing the known names.
std::unique_ptr<PlaneSegmenter> makeSegmenter(const std::string& name);

/// @brief The result of PlaneSegmenter::segment() in memory of its own.
Segmentation segmentWith(PlaneSegmenter& method, const BeamGrid& grid, const Config& config);

}  // namespace ppc
