// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/hole_filling.h"

#include "patch_plane_clustering/core/beam_planes.h"
#include "patch_plane_clustering/core/loose_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

constexpr double kMaxMean = 5.5;  // mean distance of a speck, in standard deviations of such a mean
// Mean square of its distances, in variances of noise and tolerance: of many points, and what is added for a single one,
// which may stand off by four standard deviations.
constexpr double kMaxScatter = 6.0, kSingleScatter = 10.0;

class HoleFiller {
 public:
  HoleFiller(const JudgedImage& image, const BeamPlanes& planes, HoleMemory& memory, LabelImage& labels,
             const std::vector<LabelRun>& runs)
      : grid_(image.grid),
        planes_(planes),
        tolerance_(image.tolerance),
        smallest_(image.smallest),
        labels_(labels.labels),
        runs_(runs),
        loose_(memory.loose),
        seen_(memory.seen),
        specks_(memory.specks) {
    seen_.resize(static_cast<std::size_t>(grid_.size()), 0);
    specks_.clear();
    findLoose(runs, planes.size(), smallest_, memory.points, loose_);
  }

  // Runs are those before anything was extended or filled: what was filled since was seen. @return whether anything was.
  bool fillAll() {
    forEachLoose(grid_, runs_, loose_, 0, static_cast<int>(runs_.size()) + 1, [&](int i) {
      if (seen_[i] == 0 && loose_[labels_[i]] != 0) fillFrom(i);
    });
    for (const HoleMemory::Pixel& pixel : specks_) seen_[pixel.index] = 0;
    return any_filled_;
  }

 private:
  void fillFrom(int first) {
    const std::size_t begin = specks_.size();
    const std::int32_t around = collect(first);
    if (around == 0 || static_cast<int>(specks_.size() - begin) >= smallest_ || !belongs(begin, around)) return;
    for (std::size_t p = begin; p < specks_.size(); ++p) labels_[specks_[p].index] = around;
    any_filled_ = true;
  }

  // Collects the speck at a pixel. @return the label of the only region that it touches; 0 if there is none or several.
  std::int32_t collect(int first) {
    std::int32_t around = 0;
    bool alone = true;
    const auto visit = [&](int i, int col) {
      if (!grid_.valid(i)) return;
      if (loose_[labels_[i]] == 0) {
        alone = alone && (around == 0 || around == labels_[i]);
        around = labels_[i];
      } else if (seen_[i] == 0) {
        seen_[i] = 1;
        specks_.push_back({i, col});
      }
    };
    const int cols = grid_.cols, above_last_row = grid_.size() - cols;
    std::size_t next = specks_.size();
    specks_.push_back({first, first % cols});
    seen_[first] = 1;
    while (next < specks_.size()) {
      const auto [i, col] = specks_[next++];
      if (col > 0) visit(i - 1, col - 1);
      if (col + 1 < cols) visit(i + 1, col + 1);
      if (i >= cols) visit(i - cols, col);
      if (i < above_last_row) visit(i + cols, col);
    }
    return alone ? around : 0;
  }

  // Whether the speck from `begin` on lies on a plane as well as noise lets it.
  bool belongs(std::size_t begin, std::int32_t label) const {
    double sum = 0.0, squares = 0.0, variances = 0.0, allowed = 0.0;
    for (std::size_t p = begin; p < specks_.size(); ++p) {
      const int i = specks_[p].index;
      const BeamPlanes::Meeting met = planes_.meet(i, label);
      const BeamPlanes::Errors errors = planes_.errorsAt(i);
      const double distance = grid_.range[i] - met.across / met.along;
      const double tolerated = planes_.allowedAlong(label, met.along, errors.floor);
      sum += distance;
      squares += distance * distance / (errors.sigma * errors.sigma + tolerated);
      variances += errors.sigma * errors.sigma;
      allowed += tolerated;
    }
    const auto n = static_cast<double>(specks_.size() - begin);
    const double deviation = std::sqrt(variances / n * std::min(1.0, tolerance_.inflationOf(n) / n) + allowed / n);
    return std::abs(sum / n) <= kMaxMean * deviation &&
           squares <= kMaxScatter * n + kSingleScatter;  // not if the plane is seen edge-on
  }

  const BeamGrid& grid_;
  const BeamPlanes& planes_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  std::vector<std::int32_t>& labels_;
  const std::vector<LabelRun>& runs_;
  std::vector<char>& loose_;
  std::vector<char>& seen_;
  std::vector<HoleMemory::Pixel>& specks_;
  bool any_filled_ = false;
};

}  // namespace

bool fillHoles(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes, HoleMemory& memory, LabelImage& labels,
               const std::vector<LabelRun>& runs) {
  return HoleFiller(image, BeamPlanes(image, planes), memory, labels, runs).fillAll();
}

}  // namespace ppc
