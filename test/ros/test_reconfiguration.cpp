// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/reconfiguration.h"

#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

/// Values by name and type, of one of the generated structs (default, min, max).
std::map<std::string, double> valuesOf(const PatchPlaneClusteringConfig& config) {
  dynamic_reconfigure::Config message;
  config.__toMessage__(message);
  std::map<std::string, double> values;
  for (const auto& p : message.bools) values["bool " + p.name] = p.value;
  for (const auto& p : message.ints) values["int " + p.name] = p.value;
  for (const auto& p : message.doubles) values["double " + p.name] = p.value;
  return values;
}

std::string typed(const ConfigField& field) {
  const char* types[] = {"bool ", "int ", "double "};
  return types[static_cast<int>(field.type)] + field.name;
}

TEST(Reconfiguration, CfgFileHasTheFieldsOfTheCore) {
  const auto defaults = valuesOf(PatchPlaneClusteringConfig::__getDefault__());
  const auto minima = valuesOf(PatchPlaneClusteringConfig::__getMin__());
  const auto maxima = valuesOf(PatchPlaneClusteringConfig::__getMax__());
  for (const ConfigField& field : configFields()) {
    const std::string name = typed(field);
    ASSERT_EQ(defaults.count(name), 1U) << name << " is missing in config/PatchPlaneClustering.cfg";
    EXPECT_EQ(defaults.at(name), field.get(Config())) << name;
    EXPECT_EQ(minima.at(name), field.min) << name;
    EXPECT_EQ(maxima.at(name), field.max) << name;
  }
  EXPECT_EQ(defaults.size(), configFields().size()) << "config/PatchPlaneClustering.cfg has a field too many";
}

TEST(Reconfiguration, CfgFileDescribesTheFieldsAsTheCore) {
  std::map<std::string, std::string> descriptions;
  for (const auto& parameter : PatchPlaneClusteringConfig::__getParamDescriptions__()) {
    descriptions[parameter->name] = parameter->description;
  }
  for (const ConfigField& field : configFields()) EXPECT_EQ(descriptions[field.name], field.description) << field.name;
}

TEST(Reconfiguration, EveryFieldSurvivesTheWayThereAndBack) {
  Config config;
  for (const ConfigField& field : configFields()) {
    const bool whole = field.type != ConfigField::Type::kDouble;
    field.set(config, whole ? field.min : 0.25 * field.min + 0.75 * field.max);
  }
  const Config back = fromReconfigurable(toReconfigurable(config), Config());
  for (const ConfigField& field : configFields()) EXPECT_EQ(field.get(back), field.get(config)) << field.name;
}

TEST(Reconfiguration, RefusesWhatClampingLetsThrough) {
  PatchPlaneClusteringConfig update = PatchPlaneClusteringConfig::__getDefault__();
  update.sigma_angle = std::numeric_limits<double>::quiet_NaN();
  update.__clamp__();
  try {
    fromReconfigurable(update, Config());
    FAIL() << "NaN was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'sigma_angle' = nan"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ppc
