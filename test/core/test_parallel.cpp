// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/parallel.h"

#include <gtest/gtest.h>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace ppc {
namespace {

TEST(Parallel, CallsEveryPartOnce) {
  for (const int threads : {0, 1, 2, 7}) {
    for (const int parts : {0, 1, 5, 100}) {
      std::vector<int> calls(static_cast<std::size_t>(parts), 0);
      forEachPart(threads, parts, [&](int part) { ++calls[static_cast<std::size_t>(part)]; });
      EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(parts), 1)) << threads << " threads";
    }
  }
}

TEST(PartQueue, HandsOutEachPartOnceWhoeverAsks) {
  for (const int workers : {1, 2, 3, 11}) {
    for (const int count : {0, 1, 5, 40}) {
      for (const int asking : {0, workers - 1}) {  // all by one worker: its own, then the others'
        PartQueue queue(workers, count);
        std::vector<int> calls(static_cast<std::size_t>(count), 0);
        for (int part = queue.next(asking); part >= 0; part = queue.next(asking)) ++calls[static_cast<std::size_t>(part)];
        EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(count), 1)) << workers << " workers";
        EXPECT_EQ(queue.next(0), -1);
      }
    }
  }
}

TEST(PartQueue, GivesEveryWorkerItsOwnShareFirst) {
  PartQueue queue(2, 6);
  const int asked[] = {0, 1, 1, 0, 1, 1, 0};
  const int expected[] = {0, 3, 4, 1, 5, 2, -1};
  for (int k = 0; k < 7; ++k) EXPECT_EQ(queue.next(asked[k]), expected[k]);
}

TEST(Parallel, RangesCoverAllIndicesOnce) {
  for (const int threads : {1, 2, 3}) {
    for (const int count : {0, 1, 7, 1000}) {
      std::vector<int> calls(static_cast<std::size_t>(count), 0);
      forEachRange(threads, count, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) ++calls[static_cast<std::size_t>(i)];
      });
      EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(count), 1)) << threads << " threads";
    }
  }
}

TEST(Parallel, OneThreadIsTheCallersAndTwoAreTwo) {
  const auto threadsSeen = [](int threads) {
    std::vector<std::thread::id> ids(2);
    std::atomic<int> arrived{0};
    forEachPart(threads, 2, [&](int part) {
      ids[static_cast<std::size_t>(part)] = std::this_thread::get_id();
      ++arrived;
      while (threads > 1 && arrived < 2) std::this_thread::yield();  // so that no thread takes both
    });
    return std::set<std::thread::id>(ids.begin(), ids.end());
  };
  EXPECT_EQ(threadsSeen(1), std::set<std::thread::id>{std::this_thread::get_id()});
  EXPECT_EQ(threadsSeen(2).size(), 2U);
}

TEST(Parallel, BesideIsDoneOnceItIsWaitedFor) {
  for (const int threads : {1, 2, 4}) {
    int written = 0;
    std::atomic<int> parts{0};
    Beside beside(threads, [&] { ++written; });
    forEachPart(threads, 10, [&](int) { ++parts; });
    beside.wait();
    EXPECT_EQ(written, 1) << threads << " threads";
    EXPECT_EQ(parts, 10);
  }
}

TEST(Parallel, PassesExceptionsOn) {
  for (const int threads : {1, 3}) {
    EXPECT_THROW(forEachPart(threads, 20,
                             [](int part) {
                               if (part == 11) throw std::runtime_error("part 11");
                             }),
                 std::runtime_error);
  }
}

}  // namespace
}  // namespace ppc
