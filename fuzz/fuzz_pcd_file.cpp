// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a PCD file: refused with a line that names the file, or read, and its segmentation keeps all promises.
#include "checks.h"
#include "cloud_file.h"
#include "entry.h"
#include "memory_file.h"

namespace ppc::fuzz {

void run(Input input) {
  const MemoryFile file(input.rest());
  BeamGrid grid;
  try {
    grid = readCloud(file.path());
  } catch (const std::runtime_error& error) {
    require(std::string(error.what()).rfind(file.path() + ": ", 0) == 0, "the error does not name the file");
    return;
  }
  Config config;
  config.min_size = 12;
  segmentAndCheck(grid, config);
}

}  // namespace ppc::fuzz
