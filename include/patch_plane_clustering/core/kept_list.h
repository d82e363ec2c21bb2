// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace ppc {

/// @brief A list whose elements keep their memory when it is cleared, for elements that have some: rings of points, say.
template <typename T>
class KeptList {
 public:
  void clear() { size_ = 0; }
  /// One more, with what is left in it from before. References to the others may end.
  T& add() {
    if (size_ == items_.size()) items_.emplace_back();
    return items_[size_++];
  }
  void dropLast() { --size_; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }
  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }

 private:
  std::vector<T> items_;
  std::size_t size_ = 0;
};

}  // namespace ppc
