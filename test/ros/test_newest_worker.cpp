// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/newest_worker.h"

#include <gtest/gtest.h>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <vector>

namespace ppc {
namespace {

/// A worker that is held up in item 1 until it is released.
class HeldWorker {
 public:
  /// @param last the item that ends the test.
  explicit HeldWorker(int last)
      : worker_([this, last](const int& item) {
          if (item == 1) {
            started_.set_value();
            release_.get_future().wait();
          }
          done_.push_back(item);
          if (item == last) finished_.set_value();
        }) {}

  NewestWorker<int>& worker() { return worker_; }
  void waitUntilHeld() { started_.get_future().wait(); }
  /// What was worked on, if the last item has been in time.
  std::vector<int> release() {
    release_.set_value();
    const bool in_time = finished_.get_future().wait_for(std::chrono::seconds(10)) == std::future_status::ready;
    return in_time ? done_ : std::vector<int>();
  }

 private:
  std::promise<void> started_, release_, finished_;
  std::vector<int> done_;
  NewestWorker<int> worker_;  // last: it uses all of the above
};

TEST(NewestWorker, NewestOfTheWaitingWins) {
  HeldWorker held(4);
  NewestWorker<int>& worker = held.worker();
  EXPECT_FALSE(worker.push(1).has_value());
  held.waitUntilHeld();
  EXPECT_FALSE(worker.push(2).has_value());
  EXPECT_EQ(worker.push(3), std::optional<int>(2));
  EXPECT_EQ(worker.push(4), std::optional<int>(3));
  EXPECT_EQ(held.release(), (std::vector<int>{1, 4}));
}

TEST(NewestWorker, ItemsOneByOneAreAllWorkedOn) {
  std::vector<int> done;
  for (int item = 0; item < 100; ++item) {
    std::promise<void> finished;
    NewestWorker<int> worker([&](const int& given) {
      done.push_back(given);
      finished.set_value();
    });
    EXPECT_FALSE(worker.push(item).has_value());
    ASSERT_EQ(finished.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  }
  ASSERT_EQ(done.size(), 100U);
  for (int item = 0; item < 100; ++item) EXPECT_EQ(done[static_cast<std::size_t>(item)], item);
}

TEST(NewestWorker, TakesWorkForIdleTimeOnlyIfThereIsNoOther) {
  HeldWorker held(3);
  NewestWorker<int>& worker = held.worker();
  EXPECT_TRUE(worker.pushIfIdle(1));
  held.waitUntilHeld();
  EXPECT_FALSE(worker.pushIfIdle(2));  // one is in work
  EXPECT_FALSE(worker.push(3).has_value());
  EXPECT_FALSE(worker.pushIfIdle(4));  // and one waits, which stays
  EXPECT_EQ(held.release(), (std::vector<int>{1, 3}));
}

TEST(NewestWorker, EndsWithTheItemInWorkAndDropsTheWaiting) {
  std::promise<void> started;
  std::atomic<int> done{0};
  const auto kept = std::make_shared<int>(0);
  {
    NewestWorker<std::shared_ptr<int>> worker([&](const std::shared_ptr<int>&) {
      if (done == 0) started.set_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      ++done;
    });
    worker.push(kept);
    started.get_future().wait();
    worker.push(kept);
  }
  EXPECT_EQ(done, 1);
  EXPECT_EQ(kept.use_count(), 1);  // nothing holds on to what was dropped
}

}  // namespace
}  // namespace ppc
