// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/noise_model.h"
#include "patch_plane_clustering/core/similarity.h"

#include "analytic_scenes.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ppc::testing_tools {

inline const NoiseModel kNoise(SensorModel(), 1.0);
inline const CoplanarityTolerance kTolerance{0.005, 0.02, 1.0};

// Two walls that meet in a crease, a third that is nowhere, holes, outliers; from a sensor that moves.
struct Walls {
  BeamGrid grid;
  LabelImage truth;
  std::vector<Eigen::Vector3d> planes;

  Walls(int rows, int cols) : grid(forwardBeams(rows, cols, 0.01)) {
    for (auto* origin : {&grid.origin_x, &grid.origin_y, &grid.origin_z}) origin->resize(grid.range.size());
    for (int i = 0; i < grid.size(); ++i) grid.origin_z[i] = 0.001F * static_cast<float>(i / cols);
    const Eigen::Vector3d left(-1.0, 1.0, 0.1), right(-1.0, -1.0, -0.1);
    truth = scan({wall(left, -2.0), wall(right, -2.0)}, grid);
    addNoise(grid, 0.01);
    for (int i = 0; i < grid.size(); ++i) {
      if (i % 7 == 3) grid.range[i] = kNoRange;
      if (i % 11 == 5) grid.range[i] += 0.05F;
      if (i % 29 == 8) grid.range[i] += 0.3F;
    }
    planes = {Eigen::Vector3d::Zero(), left / -2.0, right / -2.0, Eigen::Vector3d(0.2, 0.1, 0.6)};
  }
};

// Resolves a cell as CellResolver says, written plainly. Coordinates are about `center`.
class PlainResolver {
 public:
  PlainResolver(const Walls& walls, const Eigen::Vector3d& center, int middle) : walls_(walls), center_(center) {
    const double range = walls.grid.range[middle];
    direction_ = walls.grid.direction(middle).cast<double>();
    sigma_ = kNoise.sigma(range);
    distance_ = kTolerance.forNoise(sigma_).sigma_distance;
  }

  std::int32_t winner(int row, int col, int reach, std::int32_t unexplained) const {
    std::int32_t winner = unexplained;
    double best = kNoHit;
    for (std::int32_t label = 1; label < static_cast<std::int32_t>(walls_.planes.size()); ++label) {
      if (!(squared(row, col, label) <= 12.0)) continue;
      double sum = 0.0;
      int count = 0;
      for (int r = std::max(0, row - reach); r <= std::min(walls_.grid.rows - 1, row + reach); ++r) {
        for (int c = std::max(0, col - 1); c <= std::min(walls_.grid.cols - 1, col + 1); ++c) {
          if (!walls_.grid.valid(walls_.grid.index(r, c))) continue;
          sum += std::min(9.0, squared(r, c, label));
          ++count;
        }
      }
      const double mean = sum / count, total = mean + std::log(variance(label) / (sigma_ * sigma_));
      if (mean >= 5.0 || total >= best) continue;
      best = total;
      winner = label;
    }
    return winner;
  }

  double squared(int row, int col, std::int32_t label) const {
    const int i = walls_.grid.index(row, col);
    if (!walls_.grid.valid(i)) return kNoHit;
    const Eigen::Vector3d& a = walls_.planes[label];
    const Eigen::Vector3d origin = walls_.grid.origin(i).cast<double>() - center_;
    const double model = (1.0 - a.dot(origin)) / a.dot(walls_.grid.direction(i).cast<double>());
    const double e = walls_.grid.range[i] - model;
    return model > 0.0 ? e * e / variance(label) : kNoHit;
  }

 private:
  double variance(std::int32_t label) const {
    const Eigen::Vector3d& a = walls_.planes[label];
    const double along = a.dot(direction_);
    return sigma_ * sigma_ + distance_ * distance_ * std::min(kMaxSecant2, a.squaredNorm() / (along * along));
  }

  const Walls& walls_;
  Eigen::Vector3d center_, direction_;
  double sigma_ = 0.0, distance_ = 0.0;
};

}  // namespace ppc::testing_tools
