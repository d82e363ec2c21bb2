// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace ppc {

/// @brief Cross product in the plane: twice the area of the triangle (0, a, b), positive if that turns counter-clockwise.
/// (Eigen 3.4 has it for three dimensions only.)
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace ppc
