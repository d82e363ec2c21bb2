// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/moments.h"

#include <vector>

namespace ppc {

/// @brief How points stand off a region's plane a: sums of their weights w and misfits e = 1 - a . p over places (u, v) in
/// the plane, about the region's mean and in units of its radius. For 1, which is a . p but for noise, u and v are linear in
/// p, as planes through the points are: regressing e on them is fitting a plane.
struct SurfaceSums {
  Lanes places = {};   ///< points, sum w, sum w u, sum w v
  Lanes squares = {};  ///< sum w u^2, sum w u v, sum w v^2
  Lanes misfits = {};  ///< sum w e, sum w e u, sum w e v

  SurfaceSums& operator+=(const SurfaceSums& o) {
    places += o.places;
    squares += o.squares;
    misfits += o.misfits;
    return *this;
  }
  SurfaceSums& operator-=(const SurfaceSums& o) {
    places -= o.places;
    squares -= o.squares;
    misfits -= o.misfits;
    return *this;
  }
  float points() const { return places[0]; }
  float u() const { return places[1] > 0.0F ? places[2] / places[1] : 0.0F; }  ///< of the mean, along its beam
  float v() const { return places[1] > 0.0F ? places[3] / places[1] : 0.0F; }
};

/// @brief Such sums of a cell, and its place in the image, by which the region may be cut [any unit, the same along both].
struct SurfaceCell {
  float x, y;
  SurfaceSums sums;
};

/// @brief A straight cut through a region: cells with across_x x + across_y y >= at lie beyond it, where (x, y) is their
/// place in the image or, of a cut that is straight on the region's plane, (u, v).
struct SurfaceCut {
  double gain = 0.0;  ///< chi-square of one plane less that of two, one on each side
  float across_x = 0.0F, across_y = 0.0F, at = 0.0F;
  bool on_plane = false;

  float placeOf(const SurfaceCell& cell) const {
    return on_plane ? across_x * cell.sums.u() + across_y * cell.sums.v() : across_x * cell.x + across_y * cell.y;
  }
  bool isBeyond(const SurfaceCell& cell) const { return placeOf(cell) >= at; }
};

/// @brief Measures the cells of a region against its plane.
class SurfaceFrame {
 public:
  /// @param fit that of `sum`.
  SurfaceFrame(const Moments& sum, const PlaneFit& fit);

  /// @param m of a cell, weighed with the noise, about the same origin.
  SurfaceSums measure(const Moments& m) const;

 private:
  Eigen::Vector3d a_, u_, v_;  // the places of p are a . p, u . p and v . p
};

/// @brief The best of 15 cuts in each of 8 directions; gain 0 if there is none. @param fewest points that each side must
/// have.
SurfaceCut bestCut(const std::vector<SurfaceCell>& cells, double fewest);

/// @brief Such cuts that are straight on the region's plane, in directions that are evenly spread once its scatter is made
/// round: edges and creases are straight there, and bent in the image of a tilting scanner.
SurfaceCut bestCutOnPlane(const std::vector<SurfaceCell>& cells, double fewest);

/// @brief Chi-square of one plane less that of one quadratic surface, whose bend is the same over each cell.
double bowGain(const std::vector<SurfaceCell>& cells);

}  // namespace ppc
