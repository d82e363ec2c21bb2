// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

namespace ppc::bench {

/// @brief What a piece of work asked of operator new. This program replaces it to be able to count.
struct Memory {
  std::int64_t allocations = 0;
  std::int64_t bytes = 0;  ///< of all of them
  std::int64_t peak = 0;   ///< most bytes held at once, over what was held before [bytes]
};

/// @brief Runs the work and counts, threads that it starts included. Not reentrant.
Memory memoryOf(const std::function<void()>& work);

}  // namespace ppc::bench
