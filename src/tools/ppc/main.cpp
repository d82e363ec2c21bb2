// SPDX-License-Identifier: BSD-3-Clause
// ppc: planar polygons from organised clouds and bags, without a running ROS.
#include "subcommands.h"

#include <CLI/CLI.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <iostream>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

// A file that is opened must not take the place of a standard stream that was closed, or statistics would be written into
// it.
void openStandardStreams() {
  int file = 0;
  do {
    file = open("/dev/null", O_RDWR);
  } while (file >= 0 && file <= STDERR_FILENO);
  if (file > STDERR_FILENO) close(file);
}

// One line, as for all other errors.
std::string explain(const CLI::App* app, const CLI::Error& error) {
  const std::vector<std::string> remaining = app->remaining();
  const bool unknown = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !remaining.empty();
  return "ppc: " + (unknown ? "unknown subcommand '" + remaining.front() + "'" : std::string(error.what())) +
         " (--help tells more)\n";
}

}  // namespace

int main(int argc, char** argv) {
  openStandardStreams();
  CLI::App app{"Planar polygons from organised range images", "ppc"};
  app.require_subcommand(1);
  app.failure_message(explain);
  ppc::addSegment(app);
  ppc::addBag(app);
  ppc::addSimulate(app);
  ppc::addEvaluate(app);
  try {
    app.parse(argc, argv);  // runs the subcommand
    if (!std::cout.flush()) throw std::runtime_error("standard output cannot be written (disk full?)");
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
