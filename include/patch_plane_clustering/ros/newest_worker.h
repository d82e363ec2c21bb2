// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace ppc {

/// @brief Works on items in a thread of its own, one at a time. Its queue holds one item: a newer one takes the place of one
/// that still waits, so that what comes out is never older than need be, however fast items come in. Thread-safe.
template <typename Item>
class NewestWorker {
 public:
  /// @param work called in the worker's thread; must not throw.
  explicit NewestWorker(std::function<void(const Item&)> work) : work_(std::move(work)), thread_([this] { run(); }) {}

  /// Lets the item in work finish; one that waits is dropped.
  ~NewestWorker() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

  NewestWorker(const NewestWorker&) = delete;
  NewestWorker& operator=(const NewestWorker&) = delete;

  /// Hands over an item; never waits for work. @return the one that waited, which it has overtaken, if there was one: nobody
  /// will work on that.
  std::optional<Item> push(Item item) {
    std::optional<Item> overtaken(std::move(item));
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(waiting_, overtaken);
    }
    changed_.notify_one();
    return overtaken;
  }

  /// Hands over an item unless there is other work: it neither waits nor overtakes. @return whether it was taken.
  bool pushIfIdle(Item item) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (working_ || waiting_.has_value()) return false;
      waiting_ = std::move(item);
    }
    changed_.notify_one();
    return true;
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || waiting_.has_value(); });
      if (stopping_) return;
      const Item item = std::move(*waiting_);
      waiting_.reset();
      working_ = true;
      lock.unlock();
      work_(item);
      lock.lock();
      working_ = false;
    }
  }

  std::function<void(const Item&)> work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Item> waiting_;
  bool working_ = false, stopping_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace ppc
