// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}

namespace patch_plane_clustering {

/// Each adds one subcommand to `ppc`, whose callback does the work and throws std::exception with one clear line on failure.
void addSimulate(CLI::App& app);

}  // namespace patch_plane_clustering
