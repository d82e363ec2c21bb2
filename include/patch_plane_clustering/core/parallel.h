// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/part_queue.h"
#include "patch_plane_clustering/core/worker_pool.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace ppc {

/// @brief Calls f(worker) for each worker in [0, workers) (at least one), each on a thread of its own as far as there are
/// any (WorkerPool::run()), the first on the caller's; returns when all are done. One worker needs no pool.
/// @throws what f throws (the first one, once all are done).
template <typename F>
void forEachWorker(int workers, const F& f) {
  if (workers <= 1) return f(0);
  WorkerPool::ofProcess().run(workers, std::cref(f));
}

/// @brief Calls f(part) once for each part in [0, parts), on up to `threads` threads, the caller's among them; returns when
/// all are done. Which thread takes which part is open: f must write only what belongs to its part.
/// @throws as forEachWorker().
template <typename F>
void forEachPart(int threads, int parts, F&& f) {
  const int workers = std::min(threads, parts);
  PartQueue queue(workers, parts);
  forEachWorker(workers, [&](int worker) {
    for (int part = queue.next(worker); part >= 0; part = queue.next(worker)) f(part);
  });
}

/// @brief The same with working memory: f(part, memory). Each thread has one of the memories for itself (there will be as
/// many); f must not depend on what others have left in it.
template <typename Memory, typename F>
void forEachPart(int threads, int parts, std::vector<Memory>& memories, F&& f) {
  const int workers = std::max(1, std::min(threads, parts));
  if (memories.size() < static_cast<std::size_t>(workers)) memories.resize(static_cast<std::size_t>(workers));
  PartQueue queue(workers, parts);
  forEachWorker(workers, [&](int worker) {
    for (int part = queue.next(worker); part >= 0; part = queue.next(worker)) f(part, memories[worker]);
  });
}

/// @brief Calls f() once beside what its maker goes on with, on a thread that has nothing else to do, or by wait() if there
/// is none or `threads` is 1 (WorkerPool::Beside). Until then, f must not touch what others write, nor write what others
/// read.
template <typename F>
class Beside {
 public:
  Beside(int threads, F f) : f_(std::move(f)), beside_(WorkerPool::ofProcess(), threads, [this](int) { f_(); }) {}
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;
  /// Returns when f is done. @throws what f throws.
  void wait() { beside_.wait(); }

 private:
  F f_;
  WorkerPool::Beside beside_;
};

/// How many ranges forEachRange() makes of [0, count).
inline int rangeCount(int threads, int count) {
  constexpr int kRangesPerThread = 8;  // the ranges are not equally hard
  return threads > 1 ? std::max(1, std::min(threads * kRangesPerThread, count)) : 1;
}

/// @brief Calls f(begin, end) for ranges that cover [0, count), as forEachPart(). The ranges depend on the number of
/// threads: what f writes for an index must depend on the index alone.
template <typename F>
void forEachRange(int threads, int count, F&& f) {
  const int parts = rangeCount(threads, count);
  forEachPart(threads, parts, [&](int part) { f(partBegin(count, parts, part), partBegin(count, parts, part + 1)); });
}

/// @brief The same with memory for each thread: f(begin, end, memory).
template <typename Memory, typename F>
void forEachRange(int threads, int count, std::vector<Memory>& memories, F&& f) {
  const int parts = rangeCount(threads, count);
  forEachPart(threads, parts, memories, [&](int part, Memory& memory) {
    f(partBegin(count, parts, part), partBegin(count, parts, part + 1), memory);
  });
}

}  // namespace ppc
