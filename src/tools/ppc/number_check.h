// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace ppc {

/// @brief Accepts numbers in [min, max], and unlike CLI::Range neither NaN nor what follows a number.
CLI::Validator numberIn(double min, double max);

/// @brief Accepts whole numbers of 64 bits without sign; CLI11 takes -1 for the largest of them.
CLI::Validator wholeUnsigned();

}  // namespace ppc
