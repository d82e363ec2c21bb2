// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_extension.h"

#include "patch_plane_clustering/core/beam_planes.h"
#include "patch_plane_clustering/core/loose_pixels.h"
#include "patch_plane_clustering/core/part_lists.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace ppc {
namespace {

constexpr float kGate = 3.0F;         // distance of a point, in standard deviations of noise and tolerance
constexpr double kMaxScatter = 1.35;  // mean square of these: 0.97 if they are normal, 3 where a surface crosses the plane
constexpr double kMaxMean = 0.3;      // their mean, and ...
constexpr double kSignificant = 3.0;  // ... standard deviations of such a mean
constexpr std::size_t kFewest = 16;   // points that tell this

class RegionExtender {
 public:
  RegionExtender(const JudgedImage& image, const BeamPlanes& planes, ExtensionMemory& memory, LabelImage& labels,
                 const std::vector<LabelRun>& runs)
      : grid_(image.grid),
        planes_(planes),
        tolerance_(image.tolerance),
        labels_(labels.labels),
        runs_(runs),
        memory_(memory) {
    findLoose(runs, planes.size(), image.smallest, memory.points, memory.loose);
    memory.tried.resize(static_cast<std::size_t>(grid_.size()), 0);
  }

  // @return whether any region has been extended.
  bool extendAll(int threads) {
    listSteps(threads);
    bool any = false;
    memory_.reached.clear();
    for (const ExtensionMemory::Step& step : memory_.steps) {
      if (isFree(step.pixel) && memory_.tried[step.pixel] != step.label) any = extend(step) || any;
    }
    for (const int i : memory_.reached) memory_.tried[i] = 0;
    return any;
  }

 private:
  bool isFree(int i) const { return memory_.loose[labels_[i]] != 0; }

  // The steps of all regions, those of large ones first, each one's in scan order.
  void listSteps(int threads) {
    std::vector<ExtensionMemory::Step>& found = memory_.found;
    gatherInParts(threads, static_cast<int>(runs_.size()) + 1, found, memory_.rest,
                  [&](int, int begin, int end, std::vector<ExtensionMemory::Step>& out) {
                    forEachLoose(grid_, runs_, memory_.loose, begin, end, [&](int i) { listFrom(i, out); });
                  });
    std::vector<std::size_t>& next = memory_.next;
    next.assign(memory_.points.size(), 0);
    for (const ExtensionMemory::Step& step : found) ++next[step.label];
    orderLabels();
    std::size_t end = 0;
    for (const std::int32_t label : memory_.order) end += std::exchange(next[label], end);
    memory_.steps.resize(found.size());
    for (const ExtensionMemory::Step& step : found) memory_.steps[next[step.label]++] = step;
  }

  // Labels that have steps, those of large regions first.
  void orderLabels() {
    std::vector<std::int32_t>& order = memory_.order;
    order.clear();
    for (std::size_t label = 0; label < memory_.next.size(); ++label) {
      if (memory_.next[label] > 0) order.push_back(static_cast<std::int32_t>(label));
    }
    const std::vector<int>& points = memory_.points;
    std::sort(order.begin(), order.end(),
              [&](std::int32_t a, std::int32_t b) { return points[a] != points[b] ? points[a] > points[b] : a < b; });
  }

  // Appends the steps to a pixel from the regions beside it.
  void listFrom(int i, std::vector<ExtensionMemory::Step>& out) const {
    std::int32_t last = 0;
    forEachBeside(i, [&](int j) {
      const std::int32_t label = labels_[j];
      if (memory_.loose[label] != 0 || label == last) return;
      last = label;
      if (std::abs(errorOf(i, label)) <= kGate) out.push_back({label, i});
    });
  }

  template <typename F>
  void forEachBeside(int i, F&& visit) const {
    const int cols = grid_.cols;
    if (i >= cols) visit(i - cols);
    if (i + cols < grid_.size()) visit(i + cols);
    const int col = i % cols;
    if (col > 0) visit(i - 1);
    if (col + 1 < cols) visit(i + 1);
  }

  // Distance of a point from a plane along its beam, in standard deviations; infinite where the beam does not meet it.
  float errorOf(int i, std::int32_t label) const {
    const BeamPlanes::Meeting met = planes_.meet(i, label);
    if (!(met.along * met.across > 0.0)) return std::numeric_limits<float>::infinity();
    const BeamPlanes::Errors errors = planes_.errorsAt(i);
    const double variance = errors.sigma * errors.sigma + planes_.allowedAlong(label, met.along, errors.floor);
    return static_cast<float>((grid_.range[i] - met.across / met.along) / std::sqrt(variance));
  }

  bool extend(const ExtensionMemory::Step& step) {
    std::vector<int>& reached = memory_.reached;
    const std::size_t begin = reached.size();
    double sum = 0.0, squares = 0.0;
    const auto reach = [&](int i) {
      if (!grid_.valid(i) || !isFree(i) || memory_.tried[i] == step.label) return;
      const float error = errorOf(i, step.label);
      if (!(std::abs(error) <= kGate)) return;
      memory_.tried[i] = step.label;
      reached.push_back(i);
      sum += error;
      squares += double{error} * error;
    };
    reach(step.pixel);
    for (std::size_t k = begin; k < reached.size(); ++k) forEachBeside(reached[k], reach);
    const std::size_t count = reached.size() - begin;
    const auto n = static_cast<double>(count);
    const double deviation = std::sqrt(std::min(1.0, tolerance_.inflationOf(n) / n));
    if (count < kFewest || squares > kMaxScatter * n || std::abs(sum / n) > kMaxMean + kSignificant * deviation)
      return false;
    for (std::size_t k = begin; k < reached.size(); ++k) labels_[reached[k]] = step.label;
    return true;
  }

  const BeamGrid& grid_;
  const BeamPlanes& planes_;
  const CoplanarityTolerance& tolerance_;
  std::vector<std::int32_t>& labels_;
  const std::vector<LabelRun>& runs_;
  ExtensionMemory& memory_;
};

}  // namespace

bool extendRegions(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, ExtensionMemory& memory,
                   LabelImage& labels, const std::vector<LabelRun>& runs, int threads) {
  return RegionExtender(image, BeamPlanes(image, planes), memory, labels, runs).extendAll(threads);
}

}  // namespace ppc
