// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/worker_pool.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <system_error>

namespace ppc {
namespace {

constexpr std::chrono::microseconds kLookOut{50};

// Waits for a short time until it is `time`, while others may have the processor.
template <typename Time>
void lookOut(const Time& time) {
  const auto end = std::chrono::steady_clock::now() + kLookOut;
  while (!time() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

}  // namespace

struct WorkerPool::Call {
  const std::function<void(int)>& f;
  int workers, next = 0;
  std::atomic<int> left;  // workers that are not done; changed under the lock
  std::exception_ptr error;

  Call(const std::function<void(int)>& function, int count) : f(function), workers(count), left(count) {}
};

WorkerPool& WorkerPool::ofProcess() {
  static WorkerPool pool;
  return pool;
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  called_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

// Takes the next worker of an open call. Unlocks while it works.
void WorkerPool::work(Call& call, std::unique_lock<std::mutex>& lock) {
  const int worker = call.next++;
  if (call.next == call.workers) {
    open_.erase(std::find(open_.begin(), open_.end(), &call));
    any_open_ = !open_.empty();
  }
  lock.unlock();
  std::exception_ptr error;
  try {
    call.f(worker);
  } catch (...) {
    error = std::current_exception();
  }
  lock.lock();
  if (error && !call.error) call.error = error;
  if (--call.left == 0 && waiting_ > 0) done_.notify_all();  // from here on the call may be gone
}

// What a thread of the pool does.
void WorkerPool::serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto awaited = [this] { return any_open_ || ending_; };
  while (!ending_) {
    while (!open_.empty()) work(*open_.front(), lock);
    lock.unlock();
    lookOut(awaited);
    lock.lock();
    ++asleep_;
    called_.wait(lock, awaited);
    --asleep_;
  }
}

void WorkerPool::grow() {
  try {
    while (threads_.size() < wanted_) threads_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    // The system has no more of them: callers do what is left.
  }
}

void WorkerPool::run(int workers, const std::function<void(int)>& f) {
  if (workers <= 1) return f(0);
  Call call(f, workers);
  const auto others = static_cast<std::size_t>(workers - 1);
  std::unique_lock<std::mutex> lock(mutex_);
  wanted_ += others;
  grow();
  open_.push_back(&call);
  any_open_ = true;
  for (int woken = std::min(workers - 1, asleep_); woken > 0; --woken) called_.notify_one();
  while (call.next < workers) work(call, lock);
  if (call.left > 0) {
    lock.unlock();
    lookOut([&] { return call.left == 0; });
    lock.lock();
    ++waiting_;
    done_.wait(lock, [&] { return call.left == 0; });
    --waiting_;
  }
  wanted_ -= others;
  lock.unlock();
  if (call.error) std::rethrow_exception(call.error);
}

}  // namespace ppc
