// SPDX-License-Identifier: BSD-3-Clause
#include "method_options.h"

#include <yaml-cpp/yaml.h>
#include "files.h"

#include <stdexcept>

namespace ppc {
namespace {

void readYaml(const std::string& path, Config& config) {
  requireReadableFile(path);
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root.IsMap()) throw std::runtime_error("is not a list of 'name: value' lines");
    for (const auto& entry : root) {
      const auto name = entry.first.as<std::string>();
      if (!entry.second.IsScalar()) throw std::runtime_error("the value of '" + name + "' is not a number");
      setConfigField(config, name, entry.second.as<std::string>());
    }
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace

void MethodOptions::addTo(CLI::App& command) {
  command.add_option("--method", method, "Segmentation method")
      ->check(CLI::IsMember(segmenterNames()))
      ->capture_default_str();
  command.add_option("--config", config_file, "YAML file of parameters (name: value)");
  std::string names;
  for (const ConfigField& field : configFields()) names += (names.empty() ? "" : ", ") + field.name;
  command.add_option("--set", settings, "Sets one parameter, name=value; may be repeated. Names: " + names)
      ->expected(1)
      ->take_all();
  std::string own;
  for (const std::string& name : segmenterNames()) {
    std::string list;
    const auto each_method = makeSegmenter(name);
    for (const MethodParameter& each : each_method->parameters()) list += (list.empty() ? "" : ", ") + each.name;
    if (!list.empty()) own += (own.empty() ? "" : "; ") + name + ": " + list;
  }
  command.add_option("--tune", tuning, "Sets a parameter of a method other than ppc, name=value; may be repeated. " + own)
      ->expected(1)
      ->take_all();
}

std::unique_ptr<PlaneSegmenter> MethodOptions::segmenter() const {
  std::unique_ptr<PlaneSegmenter> made = makeSegmenter(method);
  for (const std::string& setting : tuning) {
    const auto equals = setting.find('=');
    double value = 0.0;
    if (equals == std::string::npos || !CLI::detail::lexical_cast(setting.substr(equals + 1), value)) {
      throw std::runtime_error("--tune " + setting + ": expected name=number");
    }
    made->setParameter(setting.substr(0, equals), value);
  }
  return made;
}

Config MethodOptions::config() const {
  Config config;
  if (!config_file.empty()) readYaml(config_file, config);
  for (const std::string& setting : settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos) throw std::runtime_error("--set " + setting + ": expected name=value");
    setConfigField(config, setting.substr(0, equals), setting.substr(equals + 1));
  }
  return config;
}

}  // namespace ppc
