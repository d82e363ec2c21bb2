// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/worker_pool.h"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace ppc {
namespace {

// Calls of each worker, whichever thread they come from.
class Calls {
 public:
  explicit Calls(int workers) : counts_(static_cast<std::size_t>(workers)) {}
  void add(int worker) { ++counts_.at(static_cast<std::size_t>(worker)); }
  bool allAre(int expected) const {
    for (const std::atomic<int>& count : counts_) {
      if (count != expected) return false;
    }
    return true;
  }

 private:
  std::vector<std::atomic<int>> counts_;
};

TEST(WorkerPool, CallsEveryWorkerOnce) {
  WorkerPool pool;
  for (const int workers : {1, 2, 3, 8, 2}) {
    Calls calls(workers);
    pool.run(workers, [&](int worker) { calls.add(worker); });
    EXPECT_TRUE(calls.allAre(1)) << workers << " workers";
  }
}

TEST(WorkerPool, FirstWorkerIsTheCallersAndThreadsStay) {
  WorkerPool pool;
  std::vector<std::thread::id> seen;
  for (int call = 0; call < 5; ++call) {
    std::vector<std::thread::id> ids(2);
    std::atomic<int> arrived{0};
    pool.run(2, [&](int worker) {
      ids[static_cast<std::size_t>(worker)] = std::this_thread::get_id();
      ++arrived;
      while (arrived < 2) std::this_thread::yield();  // so that no thread takes both
    });
    EXPECT_EQ(ids[0], std::this_thread::get_id());
    seen.push_back(ids[1]);
  }
  EXPECT_NE(seen[0], std::this_thread::get_id());
  EXPECT_EQ(seen, std::vector<std::thread::id>(5, seen[0]));
}

TEST(WorkerPool, WakesThreadsThatSleep) {
  WorkerPool pool;
  for (int call = 0; call < 3; ++call) {
    std::atomic<int> arrived{0};
    pool.run(3, [&](int) {
      ++arrived;
      while (arrived < 3) std::this_thread::yield();
    });
    EXPECT_EQ(arrived, 3);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // far longer than they look out
  }
}

TEST(WorkerPool, WaitsForAllAndThenPassesTheExceptionOn) {
  WorkerPool pool;
  for (const int thrower : {0, 1, 2}) {
    std::atomic<int> done{0};
    const auto f = [&](int worker) {
      if (worker == thrower) throw std::runtime_error("worker " + std::to_string(worker));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      ++done;
    };
    try {
      pool.run(3, f);
      ADD_FAILURE() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "worker " + std::to_string(thrower));
    }
    EXPECT_EQ(done, 2);
  }
  Calls calls(3);
  pool.run(3, [&](int worker) { calls.add(worker); });  // still serves
  EXPECT_TRUE(calls.allAre(1));
}

TEST(WorkerPool, CallsWithinCalls) {
  WorkerPool pool;
  Calls calls(3 * 3 * 3);
  for (int round = 0; round < 20; ++round) {
    pool.run(3, [&](int i) { pool.run(3, [&](int j) { pool.run(3, [&](int k) { calls.add((i * 3 + j) * 3 + k); }); }); });
  }
  EXPECT_TRUE(calls.allAre(20));
}

TEST(WorkerPool, SeveralCallersAtATime) {
  constexpr int kCallers = 4, kRounds = 300;
  WorkerPool pool;
  Calls calls(kCallers * 3);
  std::vector<std::thread> callers;
  for (int caller = 0; caller < kCallers; ++caller) {
    callers.emplace_back([&, caller] {
      for (int round = 0; round < kRounds; ++round) {
        int written[3] = {0, 0, 0};  // what workers write, the caller sees without more ado
        pool.run(3, [&](int worker) {
          calls.add(caller * 3 + worker);
          written[worker] = round;
        });
        EXPECT_EQ(written[0] + written[1] + written[2], 3 * round);
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_TRUE(calls.allAre(kRounds));
}

TEST(WorkerPool, TwoCallersNeedNotWaitForEachOther) {
  WorkerPool pool;
  std::atomic<int> arrived{0};
  const auto call = [&] {
    pool.run(2, [&](int) {
      ++arrived;
      while (arrived < 4) std::this_thread::yield();  // all four workers at once, or never
    });
  };
  std::thread other(call);
  call();
  other.join();
  EXPECT_EQ(arrived, 4);
}

TEST(WorkerPoolBeside, IsCalledOnceWhileItsCallerGoesOn) {
  WorkerPool pool;
  for (int round = 0; round < 300; ++round) {
    int written = 0;
    Calls calls(2);
    WorkerPool::Beside beside(pool, 2, [&](int) { ++written; });
    pool.run(2, [&](int worker) { calls.add(worker); });
    beside.wait();
    EXPECT_EQ(written, 1);
    EXPECT_TRUE(calls.allAre(1));
  }
}

TEST(WorkerPoolBeside, RunsOnAnotherThreadThatNoOtherCallNeeds) {
  WorkerPool pool;
  std::thread::id id;
  std::atomic<bool> done{false};
  WorkerPool::Beside beside(pool, 2, [&](int) {
    id = std::this_thread::get_id();
    done = true;
  });
  while (!done) std::this_thread::yield();
  beside.wait();
  EXPECT_NE(id, std::this_thread::get_id());
  std::thread::id other;
  std::atomic<int> arrived{0};
  pool.run(2, [&](int worker) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
    if (worker == 1) other = std::this_thread::get_id();
  });
  EXPECT_EQ(other, id);  // no second one was made
}

TEST(WorkerPoolBeside, LeavesItToItsCallerIfNoThreadIsFree) {
  WorkerPool pool;
  for (const int threads : {1, 2}) {
    std::thread::id id;
    std::atomic<int> arrived{0};
    pool.run(2, [&](int worker) {
      ++arrived;
      while (arrived < 2) std::this_thread::yield();
      if (worker == 0) {  // the other one is kept until then
        WorkerPool::Beside beside(pool, threads, [&](int) { id = std::this_thread::get_id(); });
        beside.wait();
        ++arrived;
      } else {
        while (arrived < 3) std::this_thread::yield();
      }
    });
    EXPECT_EQ(id, std::this_thread::get_id());
  }
}

TEST(WorkerPoolBeside, PassesTheExceptionOnAndMayBeGivenUp) {
  WorkerPool pool;
  for (const int threads : {1, 2}) {
    WorkerPool::Beside beside(pool, threads, [](int) { throw std::runtime_error("beside"); });
    EXPECT_THROW(beside.wait(), std::runtime_error);
    for (int round = 0; round < 100; ++round) {
      int calls = 0;
      {
        const WorkerPool::Beside given_up(pool, threads, [&](int) { ++calls; });
      }
      EXPECT_LE(calls, threads - 1);
    }
  }
  Calls calls(2);
  pool.run(2, [&](int worker) { calls.add(worker); });  // still serves
  EXPECT_TRUE(calls.allAre(1));
}

// Threads of the process, but for the one that asks, that run or wait for a processor: what they get of it is up to others.
int countAwake() {
  const std::string own = std::to_string(syscall(SYS_gettid));
  int awake = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "stat");
    const std::string stat((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const std::size_t end = stat.rfind(')');  // of its name; what it does follows
    const bool runs = end != std::string::npos && stat.compare(end, 3, ") R") == 0;
    awake += runs && task.path().filename() != own ? 1 : 0;
  }
  return awake;
}

// In how many of 20 looks, over a time in which nobody calls, a thread is awake.
int looksAwake(WorkerPool& pool, int threads) {
  pool.run(2, [](int) {});
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (countAwake() > 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const WorkerPool::Alert alert(pool, threads);
  int awake = 0;
  for (int k = 0; k < 20; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    awake += countAwake() > 0 ? 1 : 0;
  }
  return awake;
}

TEST(WorkerPoolAlert, KeepsThreadsAwakeWhileThereIsOne) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "no alert on one processor";
  WorkerPool pool;
  EXPECT_GE(looksAwake(pool, 2), 15);
  EXPECT_LE(looksAwake(pool, 1), 5);
  EXPECT_LE(looksAwake(pool, 1000), 5);  // they would only take turns
}

TEST(WorkerPoolAlert, LosesNoCall) {
  WorkerPool pool;
  for (int k = 0; k < 200; ++k) {
    const WorkerPool::Alert outer(pool, 2), inner(pool, 2);
    if (k % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::atomic<int> begun{0};
    pool.run(2, [&](int) {  // each waits for the other: a thread must have taken one
      ++begun;
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
      while (begun < 2 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      EXPECT_EQ(begun, 2);
    });
  }
}

TEST(WorkerPool, EndsWhateverItsThreadsAreDoing) {
  for (int round = 0; round < 50; ++round) {
    WorkerPool pool;
    pool.run(4, [](int) {});
    if (round % 2 == 0) std::this_thread::sleep_for(std::chrono::microseconds(10 * round));  // asleep or looking out
  }
}

}  // namespace
}  // namespace ppc
