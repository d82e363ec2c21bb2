// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/parameters.h"

#include "patch_plane_clustering/core/nearest_name.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace ppc {
namespace {

using XmlRpc::XmlRpcValue;

std::optional<double> number(XmlRpcValue value) {  // by value: XmlRpcValue converts only when not const
  if (value.getType() == XmlRpcValue::TypeInt) return static_cast<int>(value);
  if (value.getType() == XmlRpcValue::TypeDouble) return static_cast<double>(value);
  return std::nullopt;
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string range(const char* what, double min, double max) {
  std::ostringstream text;
  text.precision(10);  // 1000000, not 1e+06
  text << what << " in [" << min << ", " << max << "]";
  return text.str();
}

}  // namespace

ParameterReader::ParameterReader(const ros::NodeHandle& nh) : ns_(nh.getNamespace()) {
  // The namespace as a whole: one round trip, and what nobody asks for is seen as well.
  nh.getParam(ns_, values_);
}

std::optional<XmlRpcValue> ParameterReader::find(const std::string& name) {
  expect(name);
  if (values_.getType() != XmlRpcValue::TypeStruct || !values_.hasMember(name)) return std::nullopt;
  return values_[name];
}

void ParameterReader::expect(const std::string& name) { asked_.push_back(name); }

void ParameterReader::complain(const std::string& name, const XmlRpcValue& value, const std::string& allowed) {
  std::ostringstream text;
  text << "parameter '" << ns_ << "/" << name << "' = ";
  value.write(text);
  text << " is not " << allowed;
  errors_.push_back(text.str());
}

bool ParameterReader::getBool(const std::string& name, bool value) {
  auto found = find(name);
  if (!found) return value;
  if (found->getType() == XmlRpcValue::TypeBoolean) return static_cast<bool>(*found);
  complain(name, *found, "true or false");
  return value;
}

int ParameterReader::getInt(const std::string& name, int value, int min, int max) {
  const auto found = find(name);
  if (!found) return value;
  const auto given = number(*found);
  if (given && *given == std::round(*given) && min <= *given && *given <= max) return static_cast<int>(*given);
  complain(name, *found, range("a whole number", min, max));
  return value;
}

double ParameterReader::getDouble(const std::string& name, double value, double min, double max) {
  const auto found = find(name);
  if (!found) return value;
  const auto given = number(*found);
  if (given && min <= *given && *given <= max) return *given;  // this way round, NaN is refused
  complain(name, *found, range("a number", min, max));
  return value;
}

std::string ParameterReader::getString(const std::string& name, const std::string& value) {
  auto found = find(name);
  if (!found) return value;
  if (found->getType() == XmlRpcValue::TypeString) return static_cast<std::string>(*found);
  complain(name, *found, "a text");
  return value;
}

std::string ParameterReader::getFrame(const std::string& name, const std::string& value) {
  const std::string given = getString(name, value);
  std::string frame = !given.empty() && given[0] == '/' ? given.substr(1) : given;
  if (!frame.empty() || (given.empty() && value.empty())) return frame;
  complain(name, XmlRpcValue(given), "the name of a frame");
  return value;
}

std::string ParameterReader::getChoice(const std::string& name, const std::string& value,
                                       const std::vector<std::string>& choices) {
  auto found = find(name);
  if (!found) return value;
  if (found->getType() == XmlRpcValue::TypeString) {
    auto given = static_cast<std::string>(*found);
    if (std::find(choices.begin(), choices.end(), given) != choices.end()) return given;
  }
  complain(name, *found, "one of " + list(choices));
  return value;
}

std::vector<double> ParameterReader::getVector(const std::string& name, const std::vector<double>& value) {
  auto found = find(name);
  if (!found) return value;
  if (found->getType() == XmlRpcValue::TypeArray) {
    std::vector<double> given;
    for (int i = 0; i < found->size(); ++i) {
      const auto element = number((*found)[i]);
      if (element && std::isfinite(*element)) given.push_back(*element);
    }
    if (given.size() == value.size() && found->size() == static_cast<int>(value.size())) return given;
  }
  complain(name, *found, "a list of " + std::to_string(value.size()) + " finite numbers");
  return value;
}

std::vector<std::string> ParameterReader::unknown() const {
  std::vector<std::string> sentences;
  if (values_.getType() != XmlRpcValue::TypeStruct) return sentences;
  XmlRpcValue values = values_;  // only a non-const value has iterators in all versions
  for (const auto& member : values) {
    const std::string& name = member.first;
    // The manager's own, which a nodelet started with `nodelet standalone` shares a namespace with.
    // And a nested namespace belongs to somebody else.
    if (member.second.getType() == XmlRpcValue::TypeStruct) continue;
    if (name == "num_worker_threads" || std::find(asked_.begin(), asked_.end(), name) != asked_.end()) continue;
    sentences.push_back("unknown parameter '" + ns_ + "/" + name + "'; did you mean '" + nearestName(asked_, name) + "'?");
  }
  return sentences;
}

Config readConfig(ParameterReader& reader) {
  Config config;
  for (const ConfigField& field : configFields()) {
    const double value = field.get(config);
    switch (field.type) {
      case ConfigField::Type::kBool:
        field.set(config, reader.getBool(field.name, value != 0.0) ? 1.0 : 0.0);
        break;
      case ConfigField::Type::kInt:
        field.set(config, reader.getInt(field.name, static_cast<int>(value), static_cast<int>(field.min),
                                        static_cast<int>(field.max)));
        break;
      case ConfigField::Type::kDouble:
        field.set(config, reader.getDouble(field.name, value, field.min, field.max));
        break;
    }
  }
  return config;
}

}  // namespace ppc
