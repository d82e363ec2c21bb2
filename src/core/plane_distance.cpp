// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/plane_distance.h"

#include "patch_plane_clustering/core/near_fit.h"

#include <cmath>
#include <limits>

namespace ppc {

PlaneDistance distanceAt(const JudgedImage& image, const CreaseMeetings& meetings, const CreaseMeetings::Pair& pair,
                         const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  PlaneDistance distance;
  int points = 0;
  meetings.forEachPixel(pair, [&](int pixel) {
    ++distance.meetings;
    if (!image.grid.valid(pixel)) return;
    const double sigma = image.noise.sigmaAt(pixel, image.grid.range[pixel]);
    const RegionPoint point = regionPointAt(image, pixel, varianceOf(image, sigma));
    const double along_a = a.dot(point.at), along_b = b.dot(point.at);
    if (!(along_a > 0.0 && along_b > 0.0)) return;
    const double apart = point.at.norm() * std::abs(1.0 / along_a - 1.0 / along_b);
    ++points;
    distance.in_sigmas += apart / point.deviation();
    distance.in_tolerances += apart / image.tolerance.forNoise(sigma).sigma_distance;
  });
  if (points == 0) {
    distance.in_sigmas = distance.in_tolerances = std::numeric_limits<double>::infinity();
  } else {
    distance.in_sigmas /= points;
    distance.in_tolerances /= points;
  }
  return distance;
}

}  // namespace ppc
