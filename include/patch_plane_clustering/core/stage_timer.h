// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/segmentation.h"

#include <chrono>
#include <string>
#include <vector>

namespace ppc {

/// @brief Appends the time since the last lap to a list of stages, if there is one.
class StageTimer {
 public:
  explicit StageTimer(std::vector<StageTime>* stages) : stages_(stages) {}

  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    if (stages_ != nullptr) stages_->emplace_back(stage, std::chrono::duration<double, std::milli>(now - start_).count());
    start_ = now;
  }

 private:
  std::vector<StageTime>* stages_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace ppc
