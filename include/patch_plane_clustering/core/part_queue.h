// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>

namespace ppc {

/// First index of a part, if [0, count) is cut into `parts` of about equal size; `part` = parts gives count.
inline int partBegin(int count, int parts, int part) {
  return static_cast<int>(static_cast<long long>(count) * part / parts);
}

/// @brief Hands parts [0, count) out to workers, each once: to every worker from a share of its own first, which is the same
/// from call to call, so that what it has written last is still in its caches; then what is left of the others'.
/// Thread-safe.
class PartQueue {
 public:
  PartQueue(int workers, int count) : count_(std::clamp(workers, 1, kMostShares)) {
    for (int k = 0; k < count_; ++k) {
      shares_[k].next = partBegin(count, count_, k);
      shares_[k].end = partBegin(count, count_, k + 1);
    }
  }

  /// The next part for a worker; -1 if there is none.
  int next(int worker) {
    for (int k = 0; k < count_; ++k) {
      Share& share = shares_[(worker + k) % count_];
      if (share.next.load(std::memory_order_relaxed) >= share.end) continue;
      const int part = share.next++;
      if (part < share.end) return part;
    }
    return -1;
  }

 private:
  static constexpr int kMostShares = 8;
  struct alignas(64) Share {  // a line of the cache each
    std::atomic<int> next;
    int end;
  };

  int count_;  // of shares
  Share shares_[kMostShares];
};

}  // namespace ppc
