// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_file.h"

#include "files.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace ppc {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& cause) { throw std::runtime_error(path + ": " + cause); }

// PCL allocates what the header promises and reads past the end of short files. So the promise is held against the size of
// the file first: binary needs all bytes, ascii two a value, and LZF does not compress beyond 1 : 90.
void checkHeader(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read");
  std::string line, data;
  double width = -1, height = -1, points = -1, values = 0, bytes = 0;
  std::vector<double> sizes, counts;
  const auto numbers = [](std::istringstream& words) {
    std::vector<double> all;
    for (double value = 0; words >> value;) all.push_back(value);
    return all;
  };
  for (int n = 0; data.empty() && n < 100 && std::getline(in, line) && line.size() < 10000; ++n) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "WIDTH") words >> width;
    if (key == "HEIGHT") words >> height;
    if (key == "POINTS") words >> points;
    if (key == "SIZE") sizes = numbers(words);
    if (key == "COUNT") counts = numbers(words);
    if (key == "DATA") words >> data;
  }
  if (data.empty() || width < 0 || sizes.empty()) fail(path, "is not a PCD file (no complete header)");
  if (width * height < 1 || points == 0) fail(path, "holds no points");
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double count = i < counts.size() ? counts[i] : 1;
    values += count;
    bytes += count * sizes[i];
  }
  const double size = static_cast<double>(std::filesystem::file_size(path));
  const double pixels = std::max(points, width * height);
  const double needed = data == "binary" ? pixels * bytes : data == "ascii" ? 2 * pixels * values : pixels * bytes / 90;
  if (needed > size + 2) {
    std::ostringstream cause;
    cause << "is truncated: its header promises " << pixels << " points, the file has " << size << " bytes";
    fail(path, cause.str());
  }
  if (height <= 1) fail(path, "is not organised (height 1); the neighbourhood of points is needed");
}

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

BeamGrid readCloud(const std::string& path) {
  requireReadableFile(path);
  checkHeader(path);
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // one line of ours instead of several of PCL's
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  int status = -1;
  std::string cause;
  try {
    status = pcl::PCDReader().read(path, cloud, origin, orientation, version);
  } catch (const std::exception& error) {
    cause = std::string(" (") + error.what() + ")";
  }
  if (status < 0) fail(path, "cannot be read as a PCD file" + cause);
  const auto x = coordinates(path, cloud, "x");
  const auto y = coordinates(path, cloud, "y");
  const auto z = coordinates(path, cloud, "z");
  return beamGridFromPoints(static_cast<int>(cloud.height), static_cast<int>(cloud.width), x, y, z);
}

}  // namespace ppc
