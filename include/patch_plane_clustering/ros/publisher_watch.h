// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ppc {

/// @brief Keeps to one of the publishers of what can have only one: the angles of two joints of one name, or the lines of
/// two lasers, must not be mixed. Publishers are told apart by the name of their node. Not thread-safe.
class PublisherWatch {
 public:
  /// @brief True if a message of this publisher is to be used: the first one's, or another's once that is gone, which is so
  /// when it has been silent for two seconds or only one publisher is left.
  /// @param now time of arrival [s] @param publishers how many the topic has
  bool accepts(const std::string& publisher, double now, int publishers);

  /// @brief As accepts(): empty, or "published by /b too, but that of /a is used".
  std::string faultOf(const std::string& publisher, double now, int publishers);

  const std::string& kept() const { return kept_; }  ///< whose messages are used

 private:
  std::string kept_;
  double last_ = 0.0;
  bool any_ = false;
};

}  // namespace ppc
