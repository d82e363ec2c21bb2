// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/lanes.h"

#include <Eigen/Core>

namespace ppc {

/// @brief Two planes as four beams meet them.
class CreaseLanes {
 public:
  /// @param a,b planes (see moments.h), not 0. @param center their origin [m].
  CreaseLanes(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& center)
      : first_(a), second_(b), center_(center.cast<float>()) {}

  /// For each beam, if it meets both planes in front of it:
  struct Comparison {
    LaneMask first_farther;  ///< whether it meets the first plane behind the second one
    LaneMask apart;          ///< whether the planes are clearly apart
    LaneMask open;           ///< whether they are not, and the point is near the plane that is not its own
  };

  /// Heights of both planes over beams' origins, along their normals [m].
  struct Heights {
    Lanes first, second;
  };
  Heights heightsAt(Lanes origin_x, Lanes origin_y, Lanes origin_z) const {
    const Lanes x = origin_x - center_.x(), y = origin_y - center_.y(), z = origin_z - center_.z();
    return {first_.offset - first_.along(x, y, z), second_.offset - second_.along(x, y, z)};
  }

  /// @param heights at the beams' origins, see heightsAt(): one origin for all of them needs to be looked at once.
  /// @param variance of the distances [m^2]. @param of_first whether the beam's point is of the first plane.
  /// @param clearly_apart,within_noise of the planes, and @param farthest of a point from a plane: along the beam, in
  /// standard deviations.
  Comparison compare(const BeamLanes& beam, const Heights& heights, Lanes variance, LaneMask of_first, float clearly_apart,
                     float within_noise, float farthest) const {
    // Ranges are height over cosine; comparing their products instead saves the divisions.
    const Lanes height1 = heights.first, height2 = heights.second;
    const Lanes cosine1 = first_.along(beam.dir_x, beam.dir_y, beam.dir_z);
    const Lanes cosine2 = second_.along(beam.dir_x, beam.dir_y, beam.dir_z);
    const LaneMask met = beam.valid & (height1 * cosine1 > Lanes{}) & (height2 * cosine2 > Lanes{});
    const Lanes cosines = cosine1 * cosine2, difference = height1 * cosine2 - height2 * cosine1;
    const Lanes difference2 = difference * difference, unit2 = variance * cosines * cosines;
    const Lanes cosine = of_first ? cosine2 : cosine1;
    const Lanes residual = beam.range * cosine - (of_first ? height2 : height1);
    const LaneMask near = residual * residual < farthest * farthest * variance * cosine * cosine;
    return {met & (difference * cosines > Lanes{}), met & (difference2 > clearly_apart * clearly_apart * unit2),
            met & near & (difference2 < within_noise * within_noise * unit2)};
  }

 private:
  // A plane normal . x = offset, in lanes.
  struct PlaneLanes {
    Lanes x, y, z, offset;

    explicit PlaneLanes(const Eigen::Vector3d& a) {
      const double scale = 1.0 / a.norm();
      x = fill(static_cast<float>(a.x() * scale));
      y = fill(static_cast<float>(a.y() * scale));
      z = fill(static_cast<float>(a.z() * scale));
      offset = fill(static_cast<float>(scale));
    }
    Lanes along(Lanes ux, Lanes uy, Lanes uz) const { return x * ux + y * uy + z * uz; }
  };

  PlaneLanes first_, second_;
  Eigen::Vector3f center_;
};

}  // namespace ppc
