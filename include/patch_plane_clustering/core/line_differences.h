// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace ppc {

/// @brief What is known of a line's error less the weighted ones of the lines beside it.
struct LineDifference {
  int line;              ///< neither the first nor the last
  double before, after;  ///< weights
  double value, variance;
};

/// @brief Errors of `count` lines from their differences, by least squares: what each difference leaves unexplained is
/// small, and so is each error by itself.
/// @param error standard deviation of the errors.
/// @param robust differences that do not fit the others count for less.
std::vector<double> solveDifferences(const std::vector<LineDifference>& differences, int count, double error, bool robust);

}  // namespace ppc
