// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_meetings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace ppc {
namespace {

TEST(LabelMeetings, AreGroupedByPairsInTheOrderTheyCame) {
  for (const int labels : {2, 7, 300}) {
    std::mt19937 random(static_cast<unsigned>(labels));
    LabelMeetings found;
    for (int cell = 0; cell < 2000; ++cell) {
      const auto a = static_cast<std::int32_t>(1 + random() % static_cast<unsigned>(labels)), b = a + 1 + cell % 3;
      for (int repeat = 0; repeat < 1 + cell % 2; ++repeat) {
        found.all.push_back({Meeting::keyOf(b, a), cell, static_cast<int>(found.all.size())});
      }
    }
    std::vector<Meeting> sorted = found.all;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Meeting& a, const Meeting& b) { return a.key < b.key; });
    groupMeetings(found);
    ASSERT_EQ(found.all.size(), sorted.size());
    for (std::size_t m = 0; m < sorted.size(); ++m) {
      EXPECT_EQ(found.all[m].key, sorted[m].key);
      EXPECT_EQ(found.all[m].other, sorted[m].other);
    }
    int next = 0;
    for (std::size_t k = 0; k < found.groups.size(); ++k) {
      const MeetingGroup& group = found.groups[k];
      EXPECT_EQ(group.begin, next);
      EXPECT_FALSE(group.swapped);
      if (k > 0) {
        EXPECT_LT(found.groups[k - 1].key, group.key);
      }
      for (int m = group.begin; m < group.end; ++m) EXPECT_EQ(found.all[static_cast<std::size_t>(m)].key, group.key);
      next = group.end;
    }
    EXPECT_EQ(next, static_cast<int>(sorted.size()));
  }
}

TEST(LabelMeetings, MayBeNone) {
  LabelMeetings found;
  groupMeetings(found);
  EXPECT_TRUE(found.all.empty());
  EXPECT_TRUE(found.groups.empty());
}

}  // namespace
}  // namespace ppc
