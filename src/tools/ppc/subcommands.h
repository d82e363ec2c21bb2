// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace CLI {
class App;
}

namespace ppc {

/// Each adds one subcommand to the application. A subcommand throws std::exception with one line for the user when its input
/// or output fails; main() prints it and exits with status 1.
void addSegment(CLI::App& app);
void addBag(CLI::App& app);
void addSimulate(CLI::App& app);
void addEvaluate(CLI::App& app);

}  // namespace ppc
