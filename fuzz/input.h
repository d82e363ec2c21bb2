// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace ppc::fuzz {

/// @brief Takes values off the bytes of a fuzzer, front to back; zeros once they are used up.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::size_t remaining() const { return size_; }

  /// Any bit pattern of a number: of a float, NaN and denormal numbers too.
  template <typename Number>
  Number raw() {
    Number value{};
    const std::size_t n = std::min(sizeof value, size_);
    if (n > 0) std::memcpy(&value, data_, n);
    skip(n);
    return value;
  }

  bool flag() { return (raw<std::uint8_t>() & 1U) != 0; }

  /// In [low, high].
  int integer(int low, int high) {
    return low + static_cast<int>(raw<std::uint16_t>() % (static_cast<unsigned>(high - low) + 1U));
  }

  /// In [low, high].
  double real(double low, double high) { return low + (high - low) * raw<std::uint16_t>() / 65535.0; }

  /// @brief The next n bytes as an input of their own.
  Input split(std::size_t n) {
    n = std::min(n, size_);
    const Input part(data_, n);
    skip(n);
    return part;
  }

  /// @brief All that is left.
  std::vector<std::uint8_t> rest() {
    std::vector<std::uint8_t> bytes(data_, data_ + size_);
    size_ = 0;
    return bytes;
  }

 private:
  void skip(std::size_t n) {
    data_ += n;
    size_ -= n;
  }

  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace ppc::fuzz
