// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace ppc {

/// @brief What is known of a line's error less the weighted ones of the lines beside it, or farther off.
struct LineDifference {
  int line;              ///< neither the first nor the last, nor as near to them as `reach`
  double before, after;  ///< weights
  double value, variance;
  int reach = 1;  ///< lines to those before and after
};

/// @brief Errors of `count` lines from their differences, by least squares: what each difference leaves unexplained is
/// small, and so is each error by itself.
/// @param error standard deviation of the errors.
/// @param robust differences that do not fit the others count for less.
std::vector<double> solveDifferences(const std::vector<LineDifference>& differences, int count, double error, bool robust);

}  // namespace ppc
