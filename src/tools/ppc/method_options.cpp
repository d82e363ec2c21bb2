// SPDX-License-Identifier: BSD-3-Clause
#include "method_options.h"

#include <yaml-cpp/yaml.h>
#include "files.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace ppc {
namespace {

// A list or a map is no value of any parameter; its text is for the message that says so.
std::string inOneLine(const YAML::Node& node) {
  if (node.IsScalar()) return node.Scalar();
  YAML::Emitter text;
  text << YAML::Flow << node;
  std::string line = text.c_str();
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line.substr(0, 60);
}

void readYaml(const std::string& path, Config& config) {
  requireReadableFile(path);
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root.IsMap()) throw std::runtime_error("is not a list of 'name: value' lines");
    std::set<std::string> names;
    for (const auto& entry : root) {
      const std::string name = inOneLine(entry.first);
      if (!names.insert(name).second) throw std::runtime_error("names '" + name + "' twice");
      setConfigField(config, name, inOneLine(entry.second));
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
    if (list.empty()) continue;
    if (!own.empty()) own += "; ";
    own.append(name).append(": ").append(list);
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
