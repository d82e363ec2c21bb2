// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ppc {

/// @brief Holds the header of a PCD file against itself and against the size of the file, for PCL believes it: it allocates
/// what the header promises and reads past the end of short files.
/// @return whether it has the sensor at the origin of the points and not turned, as it has without a VIEWPOINT: PCL's reader
/// leaves numbers of its own where that line has none.
/// @throws std::runtime_error "FILE: cause"
bool checkPcdHeader(const std::string& path);

}  // namespace ppc
