// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/parameters.h"
#include "ros_test_main.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <algorithm>
#include <string>
#include <vector>

namespace ppc {
namespace {

const std::vector<std::string> kMethods = {"ppc", "ransac"};

/// The sentence that names `name`, or empty.
std::string about(const std::vector<std::string>& sentences, const std::string& name) {
  const auto found = std::find_if(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
    return sentence.find("/" + name + "'") != std::string::npos;
  });
  return found == sentences.end() ? "" : *found;
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
}

TEST(Parameters, GoodValuesAreRead) {
  ParameterReader reader(ros::NodeHandle("~good"));
  const Config config = readConfig(reader);
  EXPECT_EQ(config.patch_size, 9);
  EXPECT_EQ(config.sigma_angle, 1.0);  // a whole number is a number
  EXPECT_EQ(config.refine, false);
  EXPECT_EQ(config.min_size, 100);  // and 100.0 is whole
  EXPECT_EQ(config.sigma_distance, Config().sigma_distance);
  EXPECT_EQ(reader.getChoice("method", "ppc", kMethods), "ransac");
  EXPECT_EQ(reader.getFrame("base_frame", "base"), "tilt_base");  // as tf wrote it: with a slash
  EXPECT_EQ(reader.getFrame("fixed_frame", ""), "");
  EXPECT_EQ(reader.getVector("lever_arm", {0.0, 0.0, 0.0}), (std::vector<double>{0.0, 0.5, -1.0}));
  EXPECT_TRUE(reader.errors().empty()) << reader.errors().front();
  EXPECT_TRUE(reader.unknown().empty()) << reader.unknown().front();
}

TEST(Parameters, BadValuesAreNamedAndTheDefaultIsKept) {
  ParameterReader reader(ros::NodeHandle("~bad"));
  const Config config = readConfig(reader);
  for (const ConfigField& field : configFields()) EXPECT_EQ(field.get(config), field.get(Config())) << field.name;
  EXPECT_EQ(reader.getChoice("method", "ppc", kMethods), "ppc");
  EXPECT_EQ(reader.getString("name", "laser"), "laser");
  EXPECT_EQ(reader.getFrame("base_frame", "base"), "base");
  EXPECT_EQ(reader.getFrame("laser_frame", ""), "");
  EXPECT_EQ(reader.getVector("lever_arm", {1.0, 2.0, 3.0}), (std::vector<double>{1.0, 2.0, 3.0}));
  const auto& errors = reader.errors();
  EXPECT_EQ(errors.size(), 10U);
  expectContains(about(errors, "patch_size"), "= 1000 is not a whole number in [2, 64]");
  expectContains(about(errors, "sigma_angle"), "= wide is not a number in [0.001, 1]");
  expectContains(about(errors, "refine"), "= 2 is not true or false");
  expectContains(about(errors, "min_size"), "= 100.5 is not a whole number in [0, 1000000]");
  expectContains(about(errors, "similarity_threshold"), "= nan is not a number in [0.001, 0.999]");
  expectContains(about(errors, "method"), "= magic is not one of ppc, ransac");
  expectContains(about(errors, "name"), "= 3 is not a text");
  expectContains(about(errors, "base_frame"), "=  is not the name of a frame");
  expectContains(about(errors, "laser_frame"), "= / is not the name of a frame");
  expectContains(about(errors, "lever_arm"), "is not a list of 3 finite numbers");
}

TEST(Parameters, MisspeltNamesAreReportedWithTheNearest) {
  ParameterReader reader(ros::NodeHandle("~misspelt"));
  EXPECT_EQ(readConfig(reader).patch_size, 7);
  const auto unknown = reader.unknown();
  EXPECT_EQ(unknown.size(), 2U);
  expectContains(about(unknown, "patchsize"), "did you mean 'patch_size'?");
  expectContains(about(unknown, "sigma_distence"), "did you mean 'sigma_distance'?");
}

TEST(Parameters, AnEmptyNamespaceGivesTheDefaults) {
  ParameterReader reader(ros::NodeHandle("~nobody/was/here"));
  EXPECT_EQ(readConfig(reader).patch_size, Config().patch_size);
  EXPECT_TRUE(reader.errors().empty());
  EXPECT_TRUE(reader.unknown().empty());
}

}  // namespace
}  // namespace ppc

int main(int argc, char** argv) { return ppc::runRosTests(argc, argv, "test_parameters"); }
