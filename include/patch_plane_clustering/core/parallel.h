// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <future>
#include <vector>

namespace ppc {

/// @brief Calls f(part) once for each part in [0, parts), on up to `threads` threads, the caller's among them; returns when
/// all are done. Which thread takes which part is open: f must write only what belongs to its part.
/// @throws what f throws (the first part's exception, once all threads have stopped).
template <typename F>
void forEachPart(int threads, int parts, F&& f) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int part = next++; part < parts; part = next++) f(part);
  };
  std::vector<std::future<void>> others;
  for (int t = 1; t < std::min(threads, parts); ++t) others.push_back(std::async(std::launch::async, work));
  work();
  for (std::future<void>& other : others) other.get();
}

/// First index of a part, if [0, count) is cut into `parts` of about equal size; `part` = parts gives count.
inline int partBegin(int count, int parts, int part) {
  return static_cast<int>(static_cast<long long>(count) * part / parts);
}

/// @brief Calls f(begin, end) for ranges that cover [0, count), as forEachPart(). The ranges depend on the number of
/// threads: what f writes for an index must depend on the index alone.
template <typename F>
void forEachRange(int threads, int count, F&& f) {
  constexpr int kRangesPerThread = 4;  // the ranges are not equally hard
  const int parts = threads > 1 ? std::max(1, std::min(threads * kRangesPerThread, count)) : 1;
  forEachPart(threads, parts, [&](int part) { f(partBegin(count, parts, part), partBegin(count, parts, part + 1)); });
}

}  // namespace ppc
