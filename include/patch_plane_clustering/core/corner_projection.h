// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/contours.h"
#include "patch_plane_clustering/core/segmentation.h"

#include <Eigen/Core>

namespace ppc {

/// @brief A corner of an outline on its plane, in the plane's own coordinates [m].
struct OutlinePoint {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  Eigen::Vector2f row_step = Eigen::Vector2f::Zero();  ///< how far the point moves from one row to the next: the sides of
  Eigen::Vector2f col_step = Eigen::Vector2f::Zero();  ///< the pixel's footprint
};

/// @brief Casts the pixel corners of one region onto its plane.
///
/// The beam through a corner is interpolated from the four pixels around it (origin and direction), and continued by half a
/// step at the border of the image. Near-parallel beams cannot shoot off to infinity: the range of a corner stays within
/// a quarter of the ranges measured by the region's own pixels around it.
class CornerProjection {
 public:
  /// The arguments must outlive the object. All sizes agree.
  CornerProjection(const BeamGrid& grid, const LabelImage& labels, const PlanarRegion& region);

  /// Not thread-safe: where no own pixel around a corner has a measurement, the limits of the corner before apply.
  /// @param out room for `count` points.
  void project(const PixelCorner* corners, std::size_t count, OutlinePoint* out);

  /// How many corners so far were put where the measured ranges end, because their beams hardly meet the plane.
  std::size_t limited() const { return limited_; }

  /// The measured point of a pixel, perpendicularly onto the plane.
  Eigen::Vector2d flatten(int row, int col) const;

  /// +1 or -1: handedness of the image on the plane around a corner; it flips where the scan lines cross (the pole). 0:
  /// neither.
  int handedness(int row, int col) const;

  /// The point of the frame that plane coordinates stand for [m].
  Eigen::Vector3d lift(const Eigen::Vector2d& p) const { return centre_ + p.x() * axis_x_ + p.y() * axis_y_; }

 private:
  template <bool kOneColumn>
  void projectFour(const PixelCorner* corners, int count, OutlinePoint* out);

  const BeamGrid& grid_;
  const LabelImage& labels_;
  const PlanarRegion& region_;
  Eigen::Vector3d centre_, axis_x_, axis_y_;
  struct {
    Eigen::Vector3f axis_x, axis_y, normal;
  } single_;  // in single precision
  std::size_t limited_ = 0;
  double centre_x_, centre_y_;  // of the frame's origin, along the axes
  float shortest_, longest_;    // range measured around the last corner [m]
};

}  // namespace ppc
