// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/beam_grid.h"
#include "patch_plane_clustering/core/judged_image.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief Planes of labels as single beams meet them, and the errors to be expected there. The arguments must outlive the
/// object. Thread-safe.
class BeamPlanes {
 public:
  /// @param planes a (see moments.h) of every label.
  BeamPlanes(const JudgedImage& image, const std::vector<Eigen::Vector3d>& planes) : image_(image), planes_(planes) {}

  std::size_t size() const { return planes_.size(); }  ///< labels

  /// A beam meets a plane at the range across / along [m], ahead of it if that is positive.
  struct Meeting {
    double along, across;
  };
  Meeting meet(int pixel, std::int32_t label) const {
    const Eigen::Vector3d& a = planes_[label];
    return {a.dot(image_.grid.direction(pixel).cast<double>()),
            1.0 + a.dot(image_.center) - a.dot(image_.grid.origin(pixel).cast<double>())};
  }

  /// One standard deviation of the noise of a pixel's range, and of what planes are allowed there [m].
  struct Errors {
    double sigma, floor;
  };
  Errors errorsAt(int pixel) const {
    const double sigma = image_.noise.sigmaAt(pixel, image_.grid.range[pixel]);
    return {sigma, image_.tolerance.forNoise(sigma).sigma_distance};
  }

  /// Variance of what a plane is allowed, across it, along a beam [m^2]. @param along of the beam's Meeting.
  double allowedAlong(std::int32_t label, double along, double floor) const {
    return floor * floor * std::min(kMaxSecant2, planes_[label].squaredNorm() / (along * along));
  }

 private:
  const JudgedImage& image_;
  const std::vector<Eigen::Vector3d>& planes_;
};

}  // namespace ppc
