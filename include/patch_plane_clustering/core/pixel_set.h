// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ppc {

/// @brief A set of pixels of an image, one bit each, that knows where it has any.
class PixelSet {
 public:
  /// Makes room for an image of so many pixels. Precondition: the set is empty.
  void resize(int pixels) {
    const std::size_t words = static_cast<std::size_t>(pixels) / kBits + 2;
    if (words_.size() == words) return;
    words_.assign(words, 0);
    used_.resize(words + 1);
  }

  /// Adds those of the pixels from `first` on whose bits are set, the lowest bit being the first one's.
  void add(int first, std::uint32_t which) {
    const auto word = static_cast<std::uint32_t>(first) / kBits, shift = static_cast<std::uint32_t>(first) % kBits;
    insert(word, static_cast<std::uint64_t>(which) << shift);
    if (shift > kBits - 32U) insert(word + 1, static_cast<std::uint64_t>(which) >> (kBits - shift));
  }

  /// Calls f(pixel, which) for every four pixels from a multiple of four on of which any is in the set: `which` has their
  /// bits. Leaves the set empty.
  template <typename F>
  void takeFours(const F& f) {
    for (std::size_t k = 0; k < count_; ++k) {
      const std::uint32_t word = used_[k];
      std::uint64_t bits = words_[word];
      words_[word] = 0;
      while (bits != 0) {
        const int shift = __builtin_ctzll(bits) & ~3;
        f(static_cast<int>(word * kBits) + shift, static_cast<int>(bits >> shift & 15U));
        bits &= ~(std::uint64_t{15} << shift);
      }
    }
    count_ = 0;
  }

 private:
  static constexpr std::uint32_t kBits = 64;  // of a word

  void insert(std::uint32_t word, std::uint64_t bits) {
    used_[count_] = word;
    count_ += words_[word] == 0 && bits != 0 ? 1 : 0;
    words_[word] |= bits;
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> used_;  // the first `count_`: words with any pixel, in the order of their first
  std::size_t count_ = 0;
};

}  // namespace ppc
