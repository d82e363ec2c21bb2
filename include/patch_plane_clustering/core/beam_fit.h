// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/lanes.h"
#include "patch_plane_clustering/core/plane.h"

#include <Eigen/Core>
#include <array>
#include <optional>

namespace ppc {

/// Neighbouring pixels in the order of the image, all of one region.
struct PixelStretch {
  int begin, end;
};

/// The first pixel with a measurement; -1 if there is none.
int firstValid(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end);

/// How points weigh in a step of the fit.
enum class BeamWeights {
  kInverse,  ///< errors of inverse ranges, which are linear in n / d: for a start that knows nothing of the plane
  kNear,     ///< errors of ranges, of points no farther from the plane than half of their range
  kTrimmed   ///< errors of ranges, of points whose error is below a limit
};

/// @brief How errors along the beams count, but for kInverse: as 1 / (sigma^2 + tau^2 / cos^2), with the noise of the ranges
/// and a tolerance across the surface, that of 1 at normal incidence.
struct ErrorScale {
  double limit = 0.0;     ///< of errors so weighed [m], for kTrimmed
  double softness = 0.0;  ///< tau^2 / sigma^2
};

/// @brief Sums over points of what a step of the fit of a plane along the beams needs, and of what describes the points.
/// Coordinates a and b are those of BeamFrame, about its centre; w = (1 + s) / (cos^2 + s)
/// with the angle of incidence and ErrorScale::softness s, h the distance from the plane.
struct BeamSums {
  double w = 0, wa = 0, wb = 0, waa = 0, wab = 0, wbb = 0;  ///< where beams meet the plane, of points that are kept
  double wh = 0, wha = 0, whb = 0, whh = 0;                 ///< whh: squares of the errors along the beams
  double h = 0, hh = 0, a = 0, b = 0;                       ///< all valid points themselves
  int valid = 0;                                            ///< points
  int used = 0;                                             ///< those not seen edge-on
  int kept = 0;                                             ///< those of them that the weights kept

  BeamSums& operator+=(const BeamSums& o) { return combine(o, 1); }
  BeamSums& operator-=(const BeamSums& o) { return combine(o, -1); }

 private:
  BeamSums& combine(const BeamSums& o, int sign);
};

/// @brief What errors along the beams are measured from: a plane, a point on it, and the two axes of the frame that span
/// it best. Beams come from the side the normal points to.
class BeamFrame {
 public:
  BeamFrame() : BeamFrame(Plane(), Eigen::Vector3d::Zero()) {}
  /// @param near a point near those of the region: sums keep their digits about it.
  BeamFrame(const Plane& plane, const Eigen::Vector3d& near);

  const Plane& plane() const { return plane_; }
  const Eigen::Vector3d& centre() const { return centre_; }
  int a() const { return axes_[0]; }  ///< 0, 1, 2: x, y, z
  int b() const { return axes_[1]; }
  int across() const { return axes_[2]; }

  /// Mean of the points that were summed.
  Eigen::Vector3d meanOf(const BeamSums& sums) const;

 private:
  Plane plane_;
  Eigen::Vector3d centre_;
  std::array<int, 3> axes_;
};

/// @brief Sums the valid points of some blocks. Four at a time in single precision; add up doubles of some hundred points.
BeamSums sumBeams(const BeamGrid& grid, const PixelStretch* begin, const PixelStretch* end, const BeamFrame& frame,
                  BeamWeights weights, const ErrorScale& scale = {});

/// @brief The normal equations of a step x, (moments) x = (right side), in the order of BeamStep::x.
Eigen::Matrix3d equationsOf(const BeamSums& sums);
Eigen::Vector3d rightOf(const BeamSums& sums);

/// @brief A Gauss-Newton step: in the frame's coordinates, the plane moves by x[0] a + x[1] b + x[2] along the normal.
struct BeamStep {
  Eigen::Vector3d x;
  Eigen::Matrix3d covariance;  ///< of x, for errors of unit variance
  double gain;                 ///< what the step takes off the sum of squares
};

constexpr double kNoLimit = 1e15;  ///< of errors along the beams [m]

/// @brief How much longer a step is with a limit for it to be a Newton step, which does not depend on where it starts:
/// points come and go at the limit. As much as errors below it seem less than they are; normal ones, whose variance tells
/// where in their distribution the limit lies. The covariance is larger by the square.
double newtonScale(const BeamSums& sums, double limit);

/// What a step takes off the sum of squares of some points, whichever points it was found from.
double gainOf(const BeamSums& sums, const Eigen::Vector3d& step);

/// @param scale of the step. @return none if the points do not tell the plane.
std::optional<BeamStep> stepOf(const BeamSums& sums, double scale = 1.0);

/// @brief The plane after a step, made as a change of n / d about the origin of the beams: inverse ranges are linear in it.
/// @param origin one for all beams, about.
Plane movedBy(const BeamStep& step, const BeamFrame& frame, const Eigen::Vector3d& origin);

/// @brief How (n, d) changes with the step, in its units. @param moved the plane after the step, movedBy().
Eigen::Matrix<double, 4, 3> planeJacobian(const BeamFrame& frame, const Plane& moved);

/// @brief Covariance of (n, d) from that of the step, for independent errors. @param variance of the errors [m^2].
Eigen::Matrix4d planeCovariance(const BeamStep& step, const BeamFrame& frame, const Plane& moved, double variance);

}  // namespace ppc
