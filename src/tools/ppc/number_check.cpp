// SPDX-License-Identifier: BSD-3-Clause
#include "number_check.h"

#include <cstdint>
#include <limits>
#include <sstream>
#include <string>

namespace ppc {

CLI::Validator numberIn(double min, double max) {
  std::ostringstream range;
  range.precision(10);
  range << "in [" << min << " - " << max << "]";
  const auto check = [=, words = range.str()](const std::string& text) {
    double value = 0.0;
    const bool good = CLI::detail::lexical_cast(text, value) && min <= value && value <= max;  // this way round, NaN is bad
    return good ? std::string() : "Value " + text + " is not a number " + words;
  };
  return {check, "FLOAT " + range.str()};
}

CLI::Validator wholeUnsigned() {
  const auto check = [](const std::string& text) {
    const std::string most = std::to_string(std::numeric_limits<std::uint64_t>::max());
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    if (digits && (text.size() < most.size() || (text.size() == most.size() && text <= most))) return std::string();
    return "Value " + text + " is not a whole number in [0 - " + most + "]";
  };
  return {check, "UINT"};
}

}  // namespace ppc
