// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/config.h"

#include <XmlRpcValue.h>
#include <ros/node_handle.h>
#include <optional>
#include <string>
#include <vector>

namespace ppc {

/// @brief Reads the parameters of one namespace by name, checks their types and ranges, and keeps account of what is wrong.
///
/// A value that cannot be used is reported in errors() and the default is returned: the caller decides whether it can work
/// with that. Parameters that were set but never asked for are in unknown(). Not thread-safe.
class ParameterReader {
 public:
  /// @param nh a private node handle; its parameters are fetched once, here.
  explicit ParameterReader(const ros::NodeHandle& nh);

  bool getBool(const std::string& name, bool value);
  int getInt(const std::string& name, int value, int min, int max);
  double getDouble(const std::string& name, double value, double min, double max);  ///< min and max are allowed
  std::string getString(const std::string& name, const std::string& value);
  /// Name of a frame, without the slash at its beginning that tf had and tf2 has not; empty only if `value` is.
  std::string getFrame(const std::string& name, const std::string& value);
  /// One of `choices`; @throws nothing, as all of these.
  std::string getChoice(const std::string& name, const std::string& value, const std::vector<std::string>& choices);
  /// A list of as many finite numbers as `value` has.
  std::vector<double> getVector(const std::string& name, const std::vector<double>& value);

  /// @brief Marks a name as known without reading it (for parameters that others read).
  void expect(const std::string& name);

  /// @brief One sentence for each bad value so far, naming the parameter, its value and what is allowed.
  const std::vector<std::string>& errors() const { return errors_; }

  /// @brief One sentence for each parameter that was set but not asked for, naming the nearest known one.
  std::vector<std::string> unknown() const;

 private:
  std::optional<XmlRpc::XmlRpcValue> find(const std::string& name);
  void complain(const std::string& name, const XmlRpc::XmlRpcValue& value, const std::string& allowed);

  std::string ns_;
  XmlRpc::XmlRpcValue values_;
  std::vector<std::string> asked_;
  std::vector<std::string> errors_;
};

/// @brief The segmentation's configuration: every field of configFields() by its name, defaults and ranges as there.
Config readConfig(ParameterReader& reader);

}  // namespace ppc
