// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_file.h"

#include "files.h"
#include "pcd_header.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <cstring>
#include <stdexcept>

namespace ppc {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& cause) { throw std::runtime_error(path + ": " + cause); }

std::vector<float> coordinates(const std::string& path, const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const auto& field : cloud.fields) {
    if (field.name != name) continue;
    const bool wide = field.datatype == pcl::PCLPointField::FLOAT64;
    if (!wide && field.datatype != pcl::PCLPointField::FLOAT32) fail(path, "field '" + name + "' is not floating-point");
    std::vector<float> values(static_cast<std::size_t>(cloud.width) * cloud.height);
    const std::size_t size = wide ? 8 : 4;
    if (cloud.data.size() < values.size() * cloud.point_step || field.offset + size > cloud.point_step) {
      fail(path, "is truncated");
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto* at = &cloud.data[i * cloud.point_step + field.offset];
      double number = 0;
      if (wide) {
        std::memcpy(&number, at, size);
        values[i] = static_cast<float>(number);
      } else {
        std::memcpy(&values[i], at, size);
      }
    }
    return values;
  }
  fail(path, "has no field '" + name + "'");
}

}  // namespace

BeamGrid readCloud(const std::string& path, std::string* note) {
  requireReadableFile(path);
  const bool at_origin = checkPcdHeader(path);
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // one line of ours instead of several of PCL's
  pcl::PCLPointCloud2 cloud;
  int status = -1;
  std::string cause;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  try {
    int version = 0;
    status = pcl::PCDReader().read(path, cloud, origin, orientation, version);
  } catch (const std::exception& error) {
    cause = std::string(" (") + error.what() + ")";
  }
  if (status < 0) fail(path, "cannot be read as a PCD file" + cause);
  if (note != nullptr && !at_origin)
    *note = path + ": its VIEWPOINT is left out; its points are taken as the sensor saw them";
  const auto x = coordinates(path, cloud, "x");
  const auto y = coordinates(path, cloud, "y");
  const auto z = coordinates(path, cloud, "z");
  return beamGridFromPoints(static_cast<int>(cloud.height), static_cast<int>(cloud.width), x, y, z);
}

}  // namespace ppc
