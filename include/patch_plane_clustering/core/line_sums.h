// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"
#include "patch_plane_clustering/core/cross_product.h"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {

/// @brief Straight line through `point` in unit direction `direction`.
struct Line {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
};

/// @brief Running sums over the midpoints of a ring's sides: least-squares lines through any stretch of it in constant time.
class LineSums {
 public:
  /// @param points must outlive what is asked of them. Memory is used again.
  void setPoints(const OutlinePoint* points, std::size_t n) {
    points_ = points;
    n_ = n;
    sums_.resize(n + 1);
    sums_.front().setZero();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d m = 0.5 * (points[i].point + points[i + 1 == n ? 0 : i + 1].point);
      sums_[i + 1] = sums_[i];
      sums_[i + 1] +=
          (Eigen::Matrix<double, 5, 1>() << m.x(), m.y(), m.x() * m.x(), m.x() * m.y(), m.y() * m.y()).finished();
    }
  }

  /// Line of the sides from corner `first` to corner `last`, which may lie beyond the ring's end. A stretch too short to
  /// average the staircase out gives the line through its two ends.
  Line fit(std::size_t first, std::size_t last) const {
    const std::size_t sides = last > first ? last - first : last + n_ - first;
    const Eigen::Vector2d chord = points_[last].point - points_[first].point;
    const double length = chord.norm();
    Line line{points_[first].point,
              length > 0.0 ? Eigen::Vector2d(chord / length) : Eigen::Vector2d(Eigen::Vector2d::UnitX())};
    if (sides < 4) return line;
    Eigen::Matrix<double, 5, 1> s = sums_[last] - sums_[first];
    if (last <= first) s += sums_[n_];
    s /= static_cast<double>(sides);
    const double xx = s[2] - s[0] * s[0], xy = s[3] - s[0] * s[1], yy = s[4] - s[1] * s[1];
    const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
    return {{s[0], s[1]}, {std::cos(angle), std::sin(angle)}};
  }

 private:
  const OutlinePoint* points_ = nullptr;
  std::size_t n_ = 0;
  std::vector<Eigen::Matrix<double, 5, 1>> sums_;
};

/// @brief The point of a line nearest to `p`.
inline Eigen::Vector2d foot(const Line& line, const Eigen::Vector2d& p) {
  return line.point + line.direction.dot(p - line.point) * line.direction;
}

/// @brief Where two lines meet or, where they are nearly parallel, the middle of the feet of `near` on both.
inline Eigen::Vector2d meet(const Line& a, const Line& b, const Eigen::Vector2d& near) {
  const double sine = cross(a.direction, b.direction);
  const Eigen::Vector2d offset = b.point - a.point;
  if (std::abs(sine) < 0.2) {
    return 0.5 * (foot(a, near) + foot(b, near));
  }
  const double along = cross(offset, b.direction) / sine;
  return a.point + along * a.direction;
}

}  // namespace ppc
