// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/corner_projection.h"

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace ppc {

/// @brief How far a simplified outline may leave the corners of the region: the larger of two limits.
struct OutlineTolerance {
  double metres = 0.0;
  double pixels =
      0.0;  ///< in units of the local pixel footprint, measured across the edge: a staircase has an amplitude of 1
  OutlineTolerance halved() const { return {0.5 * metres, 0.5 * pixels}; }
  bool none() const { return !(metres > 0.0) && !(pixels > 0.0); }
};

/// @brief How far the corners of an outline are from edges that shall stand for them, in terms of the tolerance.
///
/// The excess of a corner is the square of its distance from the edge (a segment) over that of its tolerance there; above 1
/// it is too far. Footprints do not count for corners within half the tolerance in metres. The search for the farthest
/// corner is where the simplification of outlines spends its time: it works on a copy of the corners in columns, four
/// corners at a time in single precision, and looks again, in double precision, where one may be farther than the farthest
/// so far.
class OutlineExcess {
 public:
  OutlineExcess() = default;
  OutlineExcess(const OutlinePoint* points, std::size_t size, const OutlineTolerance& tolerance) {
    setPoints(points, size);
    setTolerance(tolerance);
  }
  /// Copies the corners. Memory is used again.
  void setPoints(const OutlinePoint* points, std::size_t size);
  void setTolerance(const OutlineTolerance& tolerance) {
    metres2_ = tolerance.metres * tolerance.metres;
    pixels_ = tolerance.pixels;
  }

  double at(std::size_t corner, const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  /// @brief The corner of the largest excess strictly between `first` and `last`, and its excess; `first` and -1 if there is
  /// none. The first one of several.
  /// @param last may lie beyond the ring's end, and so may the corner that is returned: they count on from `size`.
  /// @param least corners of no larger excess do not count, and need not be looked at closely.
  std::pair<std::size_t, double> farthest(std::size_t first, std::size_t last, const Eigen::Vector2d& from,
                                          const Eigen::Vector2d& to, double least = -1.0) const;

 private:
  struct Edge;
  struct RoughEdge;
  RoughEdge roughly(const Edge& edge) const;
  struct Limits;
  Limits limitsOf(double excess, const RoughEdge& edge) const;
  bool anyFarther(std::size_t begin, std::size_t count, const RoughEdge& edge, const Limits& limits) const;
  void fill(std::size_t begin, std::size_t count, const Edge& edge, double* excess) const;

  std::size_t size_ = 0, stride_ = 0;
  double metres2_ = 0.0, pixels_ = 0.0;
  std::vector<double> exact_;  // x, y of the points
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  std::vector<float> rough_;  // x, y of the points about the origin, of their row steps and of their column steps
  float reach_ = 0.0F;        // the largest of these
};

}  // namespace ppc
