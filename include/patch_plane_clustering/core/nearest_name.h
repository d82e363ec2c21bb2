// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace ppc {

/// @brief The name that a misspelt one most likely means: smallest edit distance, the first of equals. Empty without names.
std::string nearestName(const std::vector<std::string>& names, const std::string& misspelt);

}  // namespace ppc
