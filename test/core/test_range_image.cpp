// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/range_image.h"

#include "polygon_test_tools.h"

#include <gtest/gtest.h>
#include <functional>

namespace ppc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(RangeImage, RangesAreValidByRep117) {
  EXPECT_TRUE(isValidRange(0.1F, 0.05, 30.0));
  EXPECT_TRUE(isValidRange(0.5F, 0.5, 0.5));
  EXPECT_FALSE(isValidRange(0.04F, 0.05, 30.0));
  EXPECT_FALSE(isValidRange(30.5F, 0.05, 30.0));
  EXPECT_FALSE(isValidRange(std::numeric_limits<float>::infinity(), 0.05, 30.0));
  EXPECT_FALSE(isValidRange(-std::numeric_limits<float>::infinity(), 0.05, 30.0));
  EXPECT_FALSE(isValidRange(static_cast<float>(kNaN), 0.05, 30.0));
}

TEST(RangeImage, BearingsAreEvenlySpaced) {
  const RangeImage image = testing_tools::noddingScan(2, 5, 0, 0.1, 1.0);
  EXPECT_DOUBLE_EQ(image.bearing(0), -1.0);
  EXPECT_DOUBLE_EQ(image.bearing(1.5), -0.25);
  EXPECT_DOUBLE_EQ(image.bearing(4), 1.0);
}

TEST(RangeImage, ConsistentImagePasses) {
  EXPECT_NO_THROW(checkConsistent(testing_tools::noddingScan(2, 5, 0, 0.1, 1.0)));
  EXPECT_NO_THROW(checkConsistent(testing_tools::noddingScan(1, 1, 0, 0.0, 1.0)));
}

// Each fault is named in the message.
TEST(RangeImage, FaultsAreNamed) {
  const std::vector<std::pair<std::string, std::function<void(RangeImage&)>>> faults{
      {"is empty", [](RangeImage& i) { i.rows = 0; }},
      {"is empty", [](RangeImage& i) { i.cols = -3; }},
      {"poses_per_row", [](RangeImage& i) { i.poses_per_row = 0; }},
      {"ranges has 9 elements, expected 10", [](RangeImage& i) { i.ranges.pop_back(); }},
      {"intensities", [](RangeImage& i) { i.intensities.resize(3); }},
      {"tilts", [](RangeImage& i) { i.tilts.resize(1); }},
      {"row_stamps", [](RangeImage& i) { i.row_stamps.resize(7); }},
      {"line_poses", [](RangeImage& i) { i.poses_per_row = 2; }},
      {"bearings are not finite", [](RangeImage& i) { i.bearing_increment = kNaN; }},
      {"bearing_increment is zero", [](RangeImage& i) { i.bearing_increment = 0.0; }},
      {"range_min", [](RangeImage& i) { i.range_max = -1.0; }},
      {"range_min", [](RangeImage& i) { i.range_min = kNaN; }},
      {"pose is not finite", [](RangeImage& i) { i.line_poses[1].translation().x() = kNaN; }}};
  for (const auto& [name, spoil] : faults) {
    RangeImage image = testing_tools::noddingScan(2, 5, 0, 0.1, 1.0);
    spoil(image);
    try {
      checkConsistent(image);
      ADD_FAILURE() << "accepted although " << name;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace ppc
