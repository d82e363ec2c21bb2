// SPDX-License-Identifier: BSD-3-Clause
// Sweeps that are segmented before their end is certain: the same polygons come out, of every sweep, and once only.
#include "patch_plane_clustering/ros/messages.h"
#include "ros_test_main.h"
#include "wait_for.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <ros/serialization.h>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace ppc {
namespace {

/// The bytes of a message but for its sequence number, which each publisher counts by itself.
std::vector<std::uint8_t> bytesOf(PlanarPolygonArray array) {
  array.header.seq = 0;
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(array));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, array);
  return bytes;
}

class Foresight : public testing::TestWithParam<const char*> {
 protected:
  using Sweeps = std::map<ros::Time, std::vector<PlanarPolygonArray>>;

  static int common(const Sweeps& a, const Sweeps& b) {
    int count = 0;
    for (const auto& [stamp, arrays] : a) count += static_cast<int>(b.count(stamp));
    return count;
  }
};

TEST_P(Foresight, TheSamePolygonsComeOutOfEverySweepOnce) {
  ros::NodeHandle nh(std::string("/") + GetParam());
  Sweeps ahead, plain;
  std::map<ros::Time, SegmentationStatistics> statistics;
  int foreseen = 0;
  const auto a =
      nh.subscribe<PlanarPolygonArray>("polygons", 50, [&](const auto& m) { ahead[m->header.stamp].push_back(*m); });
  const auto b =
      nh.subscribe<PlanarPolygonArray>("plain_polygons", 50, [&](const auto& m) { plain[m->header.stamp].push_back(*m); });
  const auto c =
      nh.subscribe<SegmentationStatistics>("statistics", 50, [&](const auto& m) { statistics[m->header.stamp] = *m; });
  const auto d = nh.subscribe<diagnostic_msgs::DiagnosticArray>("/diagnostics", 100, [&](const auto& m) {
    for (const auto& status : m->status) {
      if (status.name.find(std::string(GetParam()) + "/ppc") == std::string::npos) continue;
      for (const auto& value : status.values) {
        if (value.key == "Images segmented before their sweep's end was certain") foreseen = std::atoi(value.value.c_str());
      }
    }
  });
  ASSERT_TRUE(waitFor([&] { return common(ahead, plain) >= 5 && foreseen >= 3 && statistics.size() >= 5; }, 100.0))
      << common(ahead, plain) << " sweeps of both, " << foreseen << " foreseen";
  for (const auto& [stamp, arrays] : ahead) {
    EXPECT_EQ(arrays.size(), 1U) << "a sweep came out more than once";
    EXPECT_GE(arrays.front().polygons.size(), 4U);
    const auto same = plain.find(stamp);
    if (same == plain.end()) continue;
    EXPECT_EQ(bytesOf(arrays.front()), bytesOf(same->second.front())) << stamp;
  }
  for (const auto& [stamp, numbers] : statistics) {
    EXPECT_GT(numbers.processor_milliseconds, 0.5F) << "the work was done, whenever it was";
    EXPECT_EQ(numbers.images_skipped, 0U);
    EXPECT_GT(numbers.lines.lines_in_images, 0U) << "the accounts are the sweep's";
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, Foresight, testing::Values("nodding", "spinning"));

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_foresight"); }
