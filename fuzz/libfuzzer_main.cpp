// SPDX-License-Identifier: BSD-3-Clause
#include "entry.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ppc::fuzz::run(ppc::fuzz::Input(data, size));
  return 0;
}
