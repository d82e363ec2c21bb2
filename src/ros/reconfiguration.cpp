// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/reconfiguration.h"

#include <dynamic_reconfigure/config_tools.h>

namespace ppc {

// Both ways go through the generated struct's own message form, whose values have names: no field is listed here.

PatchPlaneClusteringConfig toReconfigurable(const Config& config) {
  using dynamic_reconfigure::ConfigTools;
  dynamic_reconfigure::Config message;
  for (const ConfigField& field : configFields()) {
    const double value = field.get(config);
    switch (field.type) {
      case ConfigField::Type::kBool:
        ConfigTools::appendParameter(message, field.name, value != 0.0);
        break;
      case ConfigField::Type::kInt:
        ConfigTools::appendParameter(message, field.name, static_cast<int>(value));
        break;
      case ConfigField::Type::kDouble:
        ConfigTools::appendParameter(message, field.name, value);
        break;
    }
  }
  PatchPlaneClusteringConfig reconfigurable = PatchPlaneClusteringConfig::__getDefault__();
  reconfigurable.__fromMessage__(message);
  return reconfigurable;
}

Config fromReconfigurable(const PatchPlaneClusteringConfig& update, const Config& base) {
  dynamic_reconfigure::Config message;
  update.__toMessage__(message);
  Config config = base;
  for (const auto& parameter : message.bools) setConfigField(config, parameter.name, parameter.value ? 1.0 : 0.0);
  for (const auto& parameter : message.ints) setConfigField(config, parameter.name, static_cast<double>(parameter.value));
  for (const auto& parameter : message.doubles) setConfigField(config, parameter.name, parameter.value);
  return config;
}

}  // namespace ppc
