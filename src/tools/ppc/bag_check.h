// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ppc {

/// @brief True if the file begins as a bag does, or its name ends in .bag: also that of a recording that goes on (.active).
/// Precondition: a regular file; a pipe would be waited for.
bool isBag(const std::string& path);

/// @brief Checks the lengths and places that rosbag (1.15) takes from a bag of version 2.0 without a look at where they
/// lead: in a damaged one, out of the memory. Reads and unpacks the whole file once.
/// @throws std::runtime_error with file and cause; also if the recorder has not closed the bag.
void checkBag(const std::string& path);

}  // namespace ppc
