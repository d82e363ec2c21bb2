// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/publisher_watch.h"

#include <gtest/gtest.h>

namespace ppc {
namespace {

TEST(PublisherWatch, keepsToTheFirstWhileItSpeaks) {
  PublisherWatch watch;
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(watch.accepts("/motor", 10.0 + 0.1 * i, 2));
    EXPECT_FALSE(watch.accepts("/dummy", 10.05 + 0.1 * i, 2));
  }
  EXPECT_EQ(watch.kept(), "/motor");
  EXPECT_EQ(watch.faultOf("/motor", 20.0, 2), "");
  EXPECT_EQ(watch.faultOf("/dummy", 20.1, 2), "published by /dummy too, but that of /motor is used");
}

TEST(PublisherWatch, goesOverToAnotherOnceTheFirstIsGone) {
  PublisherWatch watch;
  EXPECT_TRUE(watch.accepts("/a", 10.0, 1));
  EXPECT_FALSE(watch.accepts("/b", 11.9, 2));
  EXPECT_TRUE(watch.accepts("/b", 12.1, 2));  // silent for more than two seconds
  EXPECT_FALSE(watch.accepts("/a", 12.2, 2));
  EXPECT_TRUE(watch.accepts("/c", 12.3, 1));  // the only one left
  EXPECT_EQ(watch.kept(), "/c");
}

}  // namespace
}  // namespace ppc
