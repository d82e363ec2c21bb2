// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "input.h"

namespace ppc::fuzz {

/// @brief The one entry of a fuzz target, called by libFuzzer and by the replay of its corpus. Throws if a promise is
/// broken.
void run(Input input);

}  // namespace ppc::fuzz
