// SPDX-License-Identifier: BSD-3-Clause
// ppc: planar polygons from organised clouds and bags, without a running ROS.
#include "subcommands.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <new>

int main(int argc, char** argv) {
  CLI::App app{"Planar polygons from organised range images", "ppc"};
  app.require_subcommand(1);
  ppc::addSegment(app);
  ppc::addBag(app);
  ppc::addSimulate(app);
  ppc::addEvaluate(app);
  try {
    app.parse(argc, argv);  // runs the subcommand
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  } catch (const std::bad_alloc&) {
    std::cerr << "ppc: out of memory\n";
    return 1;
  } catch (const std::exception& error) {
    std::cerr << "ppc: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
