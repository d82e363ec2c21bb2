// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace ppc {

/// @brief Counts messages that never arrived, by the holes in header.seq, of each publisher by itself. A publisher that
/// leaves seq alone, or begins to count anew, loses nothing. Not thread-safe.
class SequenceWatch {
 public:
  void see(const std::string& publisher, std::uint32_t sequence) {
    constexpr std::uint32_t kLikelyLoss = 10000;  // a larger step is another numbering
    constexpr std::size_t kMostPublishers = 100;  // nodes that come and go under ever new names must not add up
    if (newest_.size() > kMostPublishers) newest_.clear();
    const auto [known, is_new] = newest_.try_emplace(publisher, sequence);
    const std::uint32_t step = sequence - known->second;
    if (!is_new && step > 1 && step < kLikelyLoss) lost_ += step - 1;
    known->second = sequence;
  }

  std::uint32_t lost() const { return lost_; }  ///< since start

 private:
  std::map<std::string, std::uint32_t> newest_;
  std::uint32_t lost_ = 0;
};

}  // namespace ppc
