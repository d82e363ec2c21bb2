// SPDX-License-Identifier: BSD-3-Clause
// Any text as a YAML file of parameters, and any words as --set name=value: refused by name, or every field is in its range.
#include "checks.h"
#include "entry.h"
#include "memory_file.h"
#include "method_options.h"
#include "patch_plane_clustering/ros/reconfiguration.h"

#include <sstream>

namespace ppc::fuzz {
namespace {

void checkRanges(const Config& config) {
  for (const ConfigField& field : configFields()) {
    const double value = field.get(config);
    require(field.min <= value && value <= field.max, "'" + field.name + "' is out of its range");
  }
  const Config back = fromReconfigurable(toReconfigurable(config), config);
  for (const ConfigField& field : configFields()) {
    require(field.get(back) == field.get(config), "'" + field.name + "' changes on its way through dynamic_reconfigure");
  }
}

}  // namespace

void run(Input input) {
  const std::vector<std::uint8_t> bytes = input.rest();
  MethodOptions options;
  try {
    const MemoryFile file(bytes);
    options.config_file = file.path();
    checkRanges(options.config());
  } catch (const BrokenPromise&) {
    throw;
  } catch (const std::runtime_error& error) {
    require(std::string(error.what()).rfind(options.config_file + ": ", 0) == 0, "the error does not name the file");
  }
  options.config_file.clear();
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  for (std::string line; std::getline(lines, line) && options.settings.size() < 20;) {
    options.settings.push_back(line);
    try {
      checkRanges(options.config());
    } catch (const BrokenPromise&) {
      throw;
    } catch (const std::exception& error) {
      require(*error.what() != '\0', "an error without words");
      options.settings.pop_back();
    }
  }
}

}  // namespace ppc::fuzz
