// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ppc::bench {

/// @brief Keeps the calling thread, and those that it starts from then on, on the last of the processors that the process
/// had when this was first called: the first has most of the interrupts. @return its number; -1 if the system refuses.
int pinToOneProcessor();

/// @brief Gives it all of them back.
void unpin();

}  // namespace ppc::bench
