// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/worker_pool.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

namespace ppc {
namespace {

constexpr std::chrono::microseconds kLookOut{50};

}  // namespace

// Waits until it is `time`, for a short time or for as long as there is an alert, while others may have the processor.
template <typename Time>
void WorkerPool::lookOut(const Time& time) const {
  const auto end = std::chrono::steady_clock::now() + kLookOut;
  while (!time() && (alerts_ > 0 || std::chrono::steady_clock::now() < end)) std::this_thread::yield();
}

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
    ++looking_;
    lock.unlock();
    lookOut(awaited);
    lock.lock();
    --looking_;
    if (alerts_ > 0) continue;
    ++asleep_;
    called_.wait(lock, [&] { return awaited() || alerts_ > 0; });
    --asleep_;
  }
}

void WorkerPool::grow(std::size_t threads) {
  try {
    while (threads_.size() < threads) threads_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    // The system has no more of them: callers do what is left.
  }
}

// Wakes as many threads as are missing for some more to look out for work. Those that do see what is open before they sleep.
void WorkerPool::wake(int threads) {
  for (int woken = std::min(threads - looking_, asleep_); woken > 0; --woken) called_.notify_one();
}

void WorkerPool::open(Call& call) {
  open_.push_back(&call);
  any_open_ = true;
}

// Does what no thread has taken of an open call, and waits for what others have.
void WorkerPool::finish(Call& call, std::unique_lock<std::mutex>& lock) {
  while (call.next < call.workers) work(call, lock);
  if (call.left == 0) return;
  lock.unlock();
  lookOut([&] { return call.left == 0; });
  lock.lock();
  ++waiting_;
  done_.wait(lock, [&] { return call.left == 0; });
  --waiting_;
}

void WorkerPool::run(int workers, const std::function<void(int)>& f) {
  if (workers <= 1) return f(0);
  Call call(f, workers);
  const auto others = static_cast<std::size_t>(workers - 1);
  std::unique_lock<std::mutex> lock(mutex_);
  wanted_ += others;
  grow(wanted_);
  open(call);
  wake(workers - 1);
  finish(call, lock);
  wanted_ -= others;
  lock.unlock();
  if (call.error) std::rethrow_exception(call.error);
}

WorkerPool::Alert::Alert(WorkerPool& pool, int threads) {
  if (threads <= 1 || threads > static_cast<int>(std::thread::hardware_concurrency())) return;
  pool_ = &pool;
  const std::lock_guard<std::mutex> lock(pool.mutex_);
  ++pool.alerts_;
  pool.wake(threads - 1);
}

WorkerPool::Alert::~Alert() {
  if (pool_ == nullptr) return;
  const std::lock_guard<std::mutex> lock(pool_->mutex_);
  --pool_->alerts_;
}

WorkerPool::Beside::Beside(WorkerPool& pool, int threads, std::function<void(int)> f)
    : pool_(pool), f_(std::move(f)), call_(f_, 1) {
  if (threads <= 1) return;
  opened_ = true;
  const std::lock_guard<std::mutex> lock(pool.mutex_);
  pool.grow(std::max<std::size_t>(pool.wanted_, 1));
  pool.open(call_);
  pool.wake(1);
}

WorkerPool::Beside::~Beside() {
  if (waited_ || !opened_) return;
  std::unique_lock<std::mutex> lock(pool_.mutex_);
  const auto open = std::find(pool_.open_.begin(), pool_.open_.end(), &call_);
  if (open != pool_.open_.end()) {
    pool_.open_.erase(open);
    pool_.any_open_ = !pool_.open_.empty();
  } else if (call_.next > 0) {
    pool_.finish(call_, lock);
  }
}

void WorkerPool::Beside::wait() {
  waited_ = true;
  if (!opened_) return call_.f(0);
  std::unique_lock<std::mutex> lock(pool_.mutex_);
  pool_.finish(call_, lock);
  lock.unlock();
  if (call_.error) std::rethrow_exception(call_.error);
}

}  // namespace ppc
