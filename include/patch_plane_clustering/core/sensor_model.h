// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace ppc {

/// @brief Range noise of a laser (one standard deviation), as data sheets give it.
///
/// sigma(r) = scale * max(near, relative * r), or scale * max(far, relative * r) beyond far_from.
/// UTM-30LX: 10 mm to 10 m, 30 mm beyond. URG-04LX: 1 % of range, 10 mm below 1 m.
struct SensorModel {
  double noise_near = 0.01;      ///< [m]
  double noise_far = 0.03;       ///< [m]
  double noise_far_from = 10.0;  ///< range from which noise_far applies [m]
  double noise_relative = 0.0;   ///< share of the range [1]

  double sigma(double range) const {
    return std::max(range < noise_far_from ? noise_near : noise_far, noise_relative * range);
  }
};

}  // namespace ppc
