// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/config.h"

#include <gtest/gtest.h>
#include <cmath>
#include <set>
#include <stdexcept>

namespace ppc {
namespace {

template <typename Call>
std::string messageOf(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Config, DefaultsAreWithinTheirRanges) {
  const Config defaults;
  std::set<std::string> names;
  for (const ConfigField& field : configFields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name << " twice";
    EXPECT_LE(field.min, field.get(defaults)) << field.name;
    EXPECT_GE(field.max, field.get(defaults)) << field.name;
    EXPECT_LT(field.min, field.max) << field.name;
    EXPECT_FALSE(field.description.empty()) << field.name;
  }
}

TEST(Config, SmallestRegionFollowsTheImageUnlessItIsGiven) {
  Config config;
  EXPECT_EQ(smallestRegion(config, 300 * 1081), 350);
  EXPECT_EQ(smallestRegion(config, 300 * 361), 196);
  EXPECT_EQ(smallestRegion(config, 90 * 361), 60);
  EXPECT_EQ(smallestRegion(config, 300 * 1081, 0.01), 350);
  EXPECT_EQ(smallestRegion(config, 300 * 1081, 0.0025), 175);
  EXPECT_EQ(smallestRegion(config, 300 * 1081, 0.0001), 116);
  EXPECT_EQ(smallestRegion(config, 90 * 361, 0.0001), 60);
  config.min_size = 40;
  EXPECT_EQ(smallestRegion(config, 300 * 1081), 40);
  EXPECT_EQ(smallestRegion(config, 300 * 1081, 0.001), 40);
  config.min_size = 1;
  EXPECT_EQ(smallestRegion(config, 300 * 1081), 3);
}

TEST(Config, EveryFieldIsSetAndReadByItsOwnName) {
  for (const ConfigField& field : configFields()) {
    Config config;
    setConfigField(config, field.name, field.max);
    EXPECT_DOUBLE_EQ(field.get(config), field.max) << field.name;
    for (const ConfigField& other : configFields()) {
      if (other.name != field.name) {
        EXPECT_DOUBLE_EQ(other.get(config), other.get(Config{})) << field.name << " changed " << other.name;
      }
    }
    setConfigField(config, field.name, field.min);
    EXPECT_DOUBLE_EQ(field.get(config), field.min) << field.name;
  }
}

TEST(Config, ValuesOutOfRangeAreRefusedWithNameValueAndRange) {
  for (const ConfigField& field : configFields()) {
    Config config;
    for (const double value : {field.min - 1.0, field.max + 1.0, std::nan("")}) {
      const std::string message = messageOf([&] { setConfigField(config, field.name, value); });
      EXPECT_NE(message.find("'" + field.name + "'"), std::string::npos) << message;
      EXPECT_NE(message.find("in ["), std::string::npos) << message;
      EXPECT_DOUBLE_EQ(field.get(config), field.get(Config{})) << "changed all the same";
    }
  }
}

TEST(Config, WholeNumbersAreAskedForWhereNeeded) {
  Config config;
  EXPECT_NE(messageOf([&] { setConfigField(config, "patch_size", 4.5); }).find("whole number"), std::string::npos);
  EXPECT_NO_THROW(setConfigField(config, "patch_size", 9.0));
  EXPECT_EQ(config.patch_size, 9);
}

TEST(Config, TextIsParsed) {
  Config config;
  setConfigField(config, "sigma_angle", std::string("0.07"));
  EXPECT_DOUBLE_EQ(config.sigma_angle, 0.07);
  setConfigField(config, "sigma_angle", std::string("1e-2"));
  EXPECT_DOUBLE_EQ(config.sigma_angle, 0.01);
  setConfigField(config, "refine", std::string("false"));
  EXPECT_FALSE(config.refine);
  setConfigField(config, "refine", std::string("true"));
  EXPECT_TRUE(config.refine);
  for (const char* text : {"", "abc", "0.05x", "0,05", "true"}) {
    EXPECT_NE(messageOf([&] { setConfigField(config, "sigma_angle", std::string(text)); }).find("sigma_angle"),
              std::string::npos)
        << text;
  }
}

TEST(Config, UnknownNameSuggestsTheNearest) {
  Config config;
  EXPECT_NE(messageOf([&] { setConfigField(config, "sigma_angel", 0.1); }).find("'sigma_angle'"), std::string::npos);
  EXPECT_NE(messageOf([&] { setConfigField(config, "patchsize", 4); }).find("'patch_size'"), std::string::npos);
}

}  // namespace
}  // namespace ppc
