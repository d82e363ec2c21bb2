// SPDX-License-Identifier: BSD-3-Clause
// `ppc`: the offline tool. One file a subcommand.
#include "subcommands.h"

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

int main(int argc, char** argv) {
  CLI::App app("Planar polygons from tilting 2D lasers, offline", "ppc");
  app.require_subcommand(1);
  patch_plane_clustering::addSimulate(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "ppc: " << e.what() << '\n';
    return 1;
  }
  return 0;
}
