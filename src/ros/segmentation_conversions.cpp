// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include <sensor_msgs/image_encodings.h>
#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

geometry_msgs::Polygon toRing(const std::vector<Eigen::Vector3d>& vertices) {
  geometry_msgs::Polygon ring;
  ring.points.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    ring.points[i].x = static_cast<float>(vertices[i].x());
    ring.points[i].y = static_cast<float>(vertices[i].y());
    ring.points[i].z = static_cast<float>(vertices[i].z());
  }
  return ring;
}

const PlanarRegion& regionOf(const PlanarPolygon& polygon, const std::vector<PlanarRegion>& regions) {
  const auto found = std::lower_bound(regions.begin(), regions.end(), polygon.id,
                                      [](const PlanarRegion& region, std::int32_t id) { return region.id < id; });
  if (found == regions.end() || found->id != polygon.id) {
    throw std::invalid_argument("polygon of region " + std::to_string(polygon.id) + ", which is not there");
  }
  return *found;
}

}  // namespace

PlanarPolygonArray toPolygonArray(const Segmentation& segmentation, const std_msgs::Header& header) {
  PlanarPolygonArray array;
  array.header = header;
  array.polygons.resize(segmentation.polygons.size());
  for (std::size_t i = 0; i < segmentation.polygons.size(); ++i) {
    const PlanarPolygon& polygon = segmentation.polygons[i];
    const PlanarRegion& region = regionOf(polygon, segmentation.regions);
    PlanarPolygonMsg& message = array.polygons[i];
    message.id = polygon.id;
    for (int k = 0; k < 3; ++k) message.plane.coef[k] = region.plane.normal[k];
    message.plane.coef[3] = -region.plane.d;
    // The message's fourth coefficient is -d: its row and column change sign.
    const Eigen::Vector4d sign(1.0, 1.0, 1.0, -1.0);
    for (int row = 0; row < 4; ++row) {
      for (int col = 0; col < 4; ++col) {
        message.covariance[4 * row + col] = sign[row] * sign[col] * region.covariance(row, col);
      }
    }
    message.centroid.x = region.centroid.x();
    message.centroid.y = region.centroid.y();
    message.centroid.z = region.centroid.z();
    message.outer = toRing(polygon.outer);
    for (const auto& hole : polygon.holes) message.holes.push_back(toRing(hole));
    message.area = polygon.area;
    message.point_count = static_cast<std::uint32_t>(region.points);
    message.rms = region.rms;
  }
  return array;
}

sensor_msgs::Image toLabelImage(const LabelImage& labels, const std_msgs::Header& header) {
  sensor_msgs::Image image;
  image.header = header;
  image.height = static_cast<std::uint32_t>(labels.rows);
  image.width = static_cast<std::uint32_t>(labels.cols);
  image.encoding = sensor_msgs::image_encodings::TYPE_32SC1;
  image.step = image.width * sizeof(std::int32_t);
  // Bytes of a vector are cleared when it is resized: here they are only written.
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(labels.labels.data());
  image.data.assign(bytes, bytes + labels.labels.size() * sizeof(std::int32_t));
  return image;
}

SegmentationStatistics toStatistics(const Segmentation& segmentation, const std_msgs::Header& header) {
  SegmentationStatistics statistics;
  const auto& labels = segmentation.labels.labels;
  statistics.header = header;
  statistics.height = static_cast<std::uint32_t>(segmentation.labels.rows);
  statistics.width = static_cast<std::uint32_t>(segmentation.labels.cols);
  statistics.valid_points = static_cast<std::uint32_t>(segmentation.valid_points);
  statistics.planar_points =
      static_cast<std::uint32_t>(std::count_if(labels.begin(), labels.end(), [](std::int32_t id) { return id > 0; }));
  statistics.regions = static_cast<std::uint32_t>(segmentation.regions.size());
  statistics.polygons = static_cast<std::uint32_t>(segmentation.polygons.size());
  statistics.regions_without_polygon = static_cast<std::uint32_t>(segmentation.regions_without_polygon);
  for (const PlanarPolygon& polygon : segmentation.polygons) {
    statistics.vertices += static_cast<std::uint32_t>(polygon.outer.size());
    for (const auto& hole : polygon.holes) statistics.vertices += static_cast<std::uint32_t>(hole.size());
  }
  // Points and vertices are both three float32: the ratio of the bytes is the ratio of the counts.
  if (statistics.vertices > 0) {
    statistics.compression = static_cast<float>(statistics.valid_points) / static_cast<float>(statistics.vertices);
  }
  for (const auto& [name, milliseconds] : segmentation.stages) {
    statistics.stage_names.push_back(name);
    statistics.stage_milliseconds.push_back(static_cast<float>(milliseconds));
  }
  return statistics;
}

}  // namespace ppc
