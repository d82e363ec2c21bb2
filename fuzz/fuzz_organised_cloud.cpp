// SPDX-License-Identifier: BSD-3-Clause
// Organised PointCloud2 -> polygons: a message of any layout is refused by name, or its segmentation keeps all promises.
#include "checks.h"
#include "entry.h"
#include "patch_plane_clustering/ros/segmentation_conversions.h"
#include "scene.h"

namespace ppc::fuzz {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

PointField field(const char* name, std::uint32_t offset, bool wide) {
  PointField f;
  f.name = name;
  f.offset = offset;
  f.datatype = wide ? PointField::FLOAT64 : PointField::FLOAT32;
  f.count = 1;
  return f;
}

// The points of a scene, float32 or float64, with padding.
PointCloud2 takeScene(Input& input) {
  const bool wide = input.flag();
  const auto gap = static_cast<std::uint32_t>(input.integer(0, 5));
  BeamGrid grid = toBeamGrid(takeScan(input));
  grid.range = takeRanges(input, grid);
  const std::uint32_t size = wide ? 8 : 4;
  PointCloud2 cloud;
  cloud.height = static_cast<std::uint32_t>(grid.rows);
  cloud.width = static_cast<std::uint32_t>(grid.cols);
  cloud.point_step = 3 * size + gap;
  cloud.row_step = cloud.width * cloud.point_step + gap;
  cloud.fields = {field("x", gap, wide), field("y", gap + size, wide), field("z", gap + 2 * size, wide)};
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height);
  for (int i = 0; i < grid.size(); ++i) {
    const Eigen::Vector3f p = grid.point(i);
    const Eigen::Vector3d q = p.cast<double>();
    const auto row = static_cast<std::size_t>(i / grid.cols), col = static_cast<std::size_t>(i % grid.cols);
    std::uint8_t* bytes = &cloud.data[row * cloud.row_step + col * cloud.point_step + gap];
    if (wide) {
      std::memcpy(bytes, q.data(), 24);
    } else {
      std::memcpy(bytes, p.data(), 12);
    }
  }
  return cloud;
}

// A layout that nothing says is sound, over bytes that nothing says are points.
PointCloud2 takeAnything(Input& input) {
  PointCloud2 cloud;
  const bool small = input.flag();
  cloud.height = small ? static_cast<std::uint32_t>(input.integer(0, 40)) : input.raw<std::uint32_t>();
  cloud.width = small ? static_cast<std::uint32_t>(input.integer(0, 40)) : input.raw<std::uint32_t>();
  cloud.point_step = input.flag() ? 12 : input.raw<std::uint32_t>();
  cloud.row_step = input.flag() ? cloud.point_step * cloud.width : input.raw<std::uint32_t>();
  cloud.is_bigendian = input.raw<std::uint8_t>() == 255 ? 1 : 0;
  for (const char* name : {"x", "y", "z"}) {
    if (input.raw<std::uint8_t>() == 255) continue;
    cloud.fields.push_back(field(name, static_cast<std::uint32_t>(4 * cloud.fields.size()), input.flag()));
    if (input.flag()) cloud.fields.back().offset = input.raw<std::uint32_t>();
    if (input.raw<std::uint8_t>() == 255) cloud.fields.back().datatype = input.raw<std::uint8_t>();
  }
  cloud.data = input.rest();
  return cloud;
}

}  // namespace

void run(Input input) {
  const bool scene = input.flag();
  const Config config = takeConfig(input);
  const PointCloud2 cloud = scene ? takeScene(input) : takeAnything(input);
  BeamGrid grid;
  try {
    grid = gridFromCloud(cloud);
  } catch (const std::invalid_argument&) {
    return;
  }
  segmentAndCheck(grid, config);
}

}  // namespace ppc::fuzz
