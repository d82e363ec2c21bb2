// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/bag.h>

#include <functional>
#include <string>

namespace ppc {

/// @brief Lets `write` fill a bag, which appears under `path` whole or not at all. @throws std::runtime_error naming `path`
/// if it cannot be written; what else `write` throws passes.
void writeBag(const std::string& path, const std::function<void(rosbag::Bag&)>& write);

}  // namespace ppc
