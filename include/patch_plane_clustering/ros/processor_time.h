// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

namespace ppc {

/// Time that the calling thread has spent on a processor [ms]: on a busy machine less than what the clock on the wall says.
inline double threadProcessorMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace ppc
