// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/baselines/plane_segmenter.h"
#include "patch_plane_clustering/core/config.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

namespace ppc {

/// @brief The options --method, --config and --set, which every subcommand that segments has.
struct MethodOptions {
  std::string method = "ppc";
  std::string config_file;
  std::vector<std::string> settings;  ///< "name=value"; later ones win, and all win over the file
  std::vector<std::string> tuning;    ///< "name=value" for parameters that the method has for itself

  void addTo(CLI::App& command);
  /// @throws std::runtime_error naming the file or option, the parameter, the value and the allowed range.
  Config config() const;
  /// The method with its own parameters set. @throws as config().
  std::unique_ptr<PlaneSegmenter> segmenter() const;
};

}  // namespace ppc
