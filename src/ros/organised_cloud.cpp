// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/label_runs.h"
#include "patch_plane_clustering/ros/region_color.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

bool hostIsBigEndian() {
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

[[noreturn]] void refuse(const std::string& why) { throw std::invalid_argument("point cloud refused: " + why); }

// A message may come from anybody: every size is checked in 64 bits before a byte is read.
void checkLayout(const PointCloud2& cloud) {
  if (cloud.height < 2 || cloud.width < 2) {
    refuse("it is not organised (height " + std::to_string(cloud.height) + ", width " + std::to_string(cloud.width) +
           "); neighbours in space must be neighbours in the array");
  }
  if ((cloud.is_bigendian != 0) != hostIsBigEndian()) refuse("is_bigendian is not this machine's byte order");
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (row > cloud.row_step) {
    refuse("row_step = " + std::to_string(cloud.row_step) + " is less than width * point_step = " + std::to_string(row));
  }
  const std::uint64_t bytes = std::uint64_t{cloud.row_step} * (cloud.height - 1) + row;
  if (cloud.data.size() < bytes) {
    refuse("data holds " + std::to_string(cloud.data.size()) + " bytes, height and row_step need " + std::to_string(bytes));
  }
}

template <typename Number>
void readColumn(const PointCloud2& cloud, std::uint32_t offset, std::vector<float>& values) {
  values.resize(std::size_t{cloud.height} * cloud.width);
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* bytes = cloud.data.data() + row * cloud.row_step + offset;
    for (std::size_t col = 0; col < cloud.width; ++col, bytes += cloud.point_step) {
      Number value;
      std::memcpy(&value, bytes, sizeof(value));  // fields need not be aligned
      values[row * cloud.width + col] = static_cast<float>(value);
    }
  }
}

void readCoordinate(const PointCloud2& cloud, const char* name, std::vector<float>& values) {
  const auto field =
      std::find_if(cloud.fields.begin(), cloud.fields.end(), [&](const PointField& f) { return f.name == name; });
  if (field == cloud.fields.end()) refuse(std::string("it has no field '") + name + "'");
  const bool wide = field->datatype == PointField::FLOAT64;
  if (!wide && field->datatype != PointField::FLOAT32) {
    refuse(std::string("field '") + name + "' has datatype " + std::to_string(field->datatype) + ", not FLOAT32 or FLOAT64");
  }
  if (std::uint64_t{field->offset} + (wide ? 8 : 4) > cloud.point_step) {
    refuse(std::string("field '") + name + "' at offset " + std::to_string(field->offset) +
           " ends beyond point_step = " + std::to_string(cloud.point_step));
  }
  wide ? readColumn<double>(cloud, field->offset, values) : readColumn<float>(cloud, field->offset, values);
}

PointField pointField(const char* name, std::uint32_t offset, std::uint8_t datatype) {
  PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = 1;
  return field;
}

// Bytes b, g, r, 0 of each label from 0 to the largest.
std::vector<std::uint32_t> packedColors(const LabelImage& labels) {
  const std::int32_t highest = highestLabel(labels);
  std::vector<std::uint32_t> colors;
  for (std::int32_t label = 0; label <= highest; ++label) {
    const RegionColor color = regionColor(label);
    colors.push_back(std::uint32_t{color.r} << 16 | std::uint32_t{color.g} << 8 | color.b);
  }
  return colors;
}

}  // namespace

BeamGrid gridFromCloud(const PointCloud2& cloud) {
  CloudCoordinates coordinates;
  BeamGrid grid;
  gridFromCloud(cloud, coordinates, grid);
  return grid;
}

void gridFromCloud(const PointCloud2& cloud, CloudCoordinates& coordinates, BeamGrid& grid) {
  checkLayout(cloud);
  readCoordinate(cloud, "x", coordinates.x);
  readCoordinate(cloud, "y", coordinates.y);
  readCoordinate(cloud, "z", coordinates.z);
  beamGridFromPoints(static_cast<int>(cloud.height), static_cast<int>(cloud.width), coordinates.x, coordinates.y,
                     coordinates.z, Eigen::Vector3f::Zero(), grid);
}

PointCloud2 toSegmentedCloud(const BeamGrid& grid, const LabelImage& labels, const std_msgs::Header& header) {
  struct Point {
    float x, y, z;
    std::uint32_t rgb;  // bytes b, g, r, 0: what rviz and PCL expect behind a float32 field
    std::uint32_t label;
  };
  if (labels.labels.size() != static_cast<std::size_t>(grid.size())) {
    throw std::invalid_argument("label image and grid differ in size");
  }
  PointCloud2 cloud;
  cloud.header = header;
  cloud.height = static_cast<std::uint32_t>(grid.rows);
  cloud.width = static_cast<std::uint32_t>(grid.cols);
  cloud.fields = {pointField("x", 0, PointField::FLOAT32), pointField("y", 4, PointField::FLOAT32),
                  pointField("z", 8, PointField::FLOAT32), pointField("rgb", 12, PointField::FLOAT32),
                  pointField("label", 16, PointField::UINT32)};
  cloud.is_bigendian = hostIsBigEndian();
  cloud.point_step = sizeof(Point);
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = false;
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height);
  const std::vector<std::uint32_t> colors = packedColors(labels);
  std::uint8_t* out = cloud.data.data();
  for (int i = 0; i < grid.size(); ++i, out += sizeof(Point)) {
    const std::int32_t label = labels.labels[static_cast<std::size_t>(i)];
    const Eigen::Vector3f position = grid.point(i);
    const Point point{position.x(), position.y(), position.z(), colors[static_cast<std::size_t>(std::max(0, label))],
                      static_cast<std::uint32_t>(label)};
    std::memcpy(out, &point, sizeof(Point));
  }
  return cloud;
}

}  // namespace ppc
