// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ppc {

/// @brief While it lives, SIGINT, SIGTERM, SIGHUP and SIGPIPE remove the file `path` before they end the program as usual.
/// One at a time; not thread-safe.
class RemovedWhenInterrupted {
 public:
  explicit RemovedWhenInterrupted(const std::string& path);
  ~RemovedWhenInterrupted();
  RemovedWhenInterrupted(const RemovedWhenInterrupted&) = delete;
  RemovedWhenInterrupted& operator=(const RemovedWhenInterrupted&) = delete;
};

}  // namespace ppc
