// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ppc {

/// @brief Threads that stay, for work too short to make threads for it. After some they look out for more for about as long
/// as it would take to wake them (50 us), then sleep; as long as there is a WorkerPool::Alert, they do not sleep. Thread
/// safe: several threads may call run() at a time, also from within f.
class WorkerPool {
 public:
  WorkerPool() = default;
  ~WorkerPool();  ///< Ends the threads; no call may be under way.
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// @brief The one of the process. It has no threads before its first call, and ends them when the process ends or this
  /// library is unloaded. So no f may call exit(), nor may a forked child, which has none of the threads; _exit() does.
  static WorkerPool& ofProcess();

  /// @brief Calls f(worker) once for each worker in [0, workers) (at least one) and returns when all are done: the first on
  /// the caller's thread, each of the others on one of the pool's, or on the caller's if none has taken it by the time that
  /// the caller has no other left. The pool grows to as many threads as the calls under way ask for.
  /// @throws what f throws (the first one, once all workers are done).
  void run(int workers, const std::function<void(int)>& f);

  /// @brief One call of a function beside what its caller goes on with. It takes a thread of the pool that is free, and asks
  /// for none beyond those that other calls do: so that a caller who keeps to a number of threads keeps to it meanwhile.
  class Beside;

  /// @brief While there is one, threads of the pool look out for work without sleeping, and let others have the processor.
  /// For a task of some milliseconds that calls run() every now and then: to wake a thread takes 20 to 50 us, more where a
  /// hypervisor has to be asked.
  class Alert;

 private:
  struct Call {
    const std::function<void(int)>& f;
    int workers, next = 0;
    std::atomic<int> left;  // workers that are not done; changed under the lock
    std::exception_ptr error;

    Call(const std::function<void(int)>& function, int count) : f(function), workers(count), left(count) {}
  };

  void serve();
  void grow(std::size_t threads);
  void wake(int threads);
  void open(Call& call);
  void finish(Call& call, std::unique_lock<std::mutex>& lock);
  void work(Call& call, std::unique_lock<std::mutex>& lock);
  template <typename Time>
  void lookOut(const Time& time) const;

  std::mutex mutex_;  // guards all that follows, and the calls
  std::condition_variable called_, done_;
  std::vector<Call*> open_;            // calls with workers that no thread has taken, oldest first
  std::atomic<bool> any_open_{false};  // to look out for without the lock; changed with it, as `ending_`
  std::atomic<bool> ending_{false};
  std::atomic<int> alerts_{0};    // likewise
  std::size_t wanted_ = 0;        // threads that the calls under way ask for
  int looking_ = 0;               // threads of the pool that look out for work
  int asleep_ = 0, waiting_ = 0;  // threads of the pool, and callers, that must be woken
  std::vector<std::thread> threads_;
};

class WorkerPool::Alert {
 public:
  /// @param threads that the task may use, the caller's among them; with one, or more than there are processors, there is no
  /// alert.
  Alert(WorkerPool& pool, int threads);
  ~Alert();
  Alert(const Alert&) = delete;
  Alert& operator=(const Alert&) = delete;

 private:
  WorkerPool* pool_ = nullptr;
};

class WorkerPool::Beside {
 public:
  /// @param threads that the caller may use, itself among them; with one, wait() does it all.
  /// @param f called once with 0, on any thread.
  Beside(WorkerPool& pool, int threads, std::function<void(int)> f);
  ~Beside();  ///< Waits, unless wait() has; but calls f no more if nobody has begun to.
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  /// @brief Returns when f is done; calls it itself if no thread has begun to. @throws what f throws.
  void wait();

 private:
  WorkerPool& pool_;
  const std::function<void(int)> f_;
  Call call_;
  bool opened_ = false, waited_ = false;
};

}  // namespace ppc
