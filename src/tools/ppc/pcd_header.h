// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ppc {

/// @brief Holds the header of a PCD file against itself and against the size of the file, for PCL believes it: it allocates
/// what the header promises and reads past the end of short files.
/// @throws std::runtime_error "FILE: cause"
void checkPcdHeader(const std::string& path);

}  // namespace ppc
