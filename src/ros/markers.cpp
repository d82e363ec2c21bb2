// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/markers.h"

#include "patch_plane_clustering/ros/region_color.h"
#include "patch_plane_clustering/ros/triangulation.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace ppc {
namespace {

using visualization_msgs::Marker;

constexpr float kFaceOpacity = 0.6F;
constexpr double kTextOffset = 0.03;  // in front of the face [m]

Marker makeMarker(const std_msgs::Header& header, const char* ns, int type) {
  Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  return marker;
}

geometry_msgs::Point toPoint(const Eigen::Vector3d& position) {
  geometry_msgs::Point point;
  point.x = position.x();
  point.y = position.y();
  point.z = position.z();
  return point;
}

std_msgs::ColorRGBA toColor(std::int32_t id, float opacity) {
  const RegionColor color = regionColor(id);
  std_msgs::ColorRGBA message;
  message.r = color.r / 255.0F;
  message.g = color.g / 255.0F;
  message.b = color.b / 255.0F;
  message.a = opacity;
  return message;
}

void addRing(const std::vector<Eigen::Vector3d>& ring, const std_msgs::ColorRGBA& color, Marker& lines) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    lines.points.push_back(toPoint(ring[i]));
    lines.points.push_back(toPoint(ring[(i + 1) % ring.size()]));
    lines.colors.insert(lines.colors.end(), 2, color);
  }
}

/// Thin in a cardboard box, visible in a hall [m].
double lineWidth(const std::vector<PlanarRegion>& regions) {
  double farthest = 0.0;
  for (const PlanarRegion& region : regions) farthest = std::max(farthest, region.centroid.norm());
  return std::clamp(0.004 * farthest, 0.001, 0.02);
}

Marker makeText(const PlanarRegion& region, const std_msgs::Header& header) {
  Marker text = makeMarker(header, "ids", Marker::TEXT_VIEW_FACING);
  text.id = region.id;
  text.text = std::to_string(region.id);
  text.pose.position = toPoint(region.centroid + kTextOffset * region.plane.normal);
  text.scale.z = std::clamp(0.05 * region.centroid.norm(), 0.03, 0.3);  // legible from the sensor
  text.color.r = text.color.g = text.color.b = text.color.a = 1.0F;
  return text;
}

}  // namespace

visualization_msgs::MarkerArray toMarkers(const Segmentation& segmentation, const std_msgs::Header& header) {
  visualization_msgs::MarkerArray array;
  array.markers.push_back(makeMarker(header, "", Marker::CUBE));
  array.markers.back().action = Marker::DELETEALL;

  // One marker for all faces and one for all outlines keep rviz fluid. rviz lights a face from one side only unless its
  // vertices have colours.
  Marker faces = makeMarker(header, "faces", Marker::TRIANGLE_LIST);
  Marker outlines = makeMarker(header, "outlines", Marker::LINE_LIST);
  faces.color = toColor(0, kFaceOpacity);
  outlines.color = toColor(0, 1.0F);
  outlines.scale.x = lineWidth(segmentation.regions);
  for (const PlanarPolygon& polygon : segmentation.polygons) {
    const auto region = std::find_if(segmentation.regions.begin(), segmentation.regions.end(),
                                     [&](const PlanarRegion& candidate) { return candidate.id == polygon.id; });
    if (region == segmentation.regions.end()) continue;
    const auto triangles = triangulate(polygon, region->plane.normal);
    for (const Eigen::Vector3d& corner : triangles) faces.points.push_back(toPoint(corner));
    faces.colors.insert(faces.colors.end(), triangles.size(), toColor(polygon.id, kFaceOpacity));
    addRing(polygon.outer, toColor(polygon.id, 1.0F), outlines);
    for (const auto& hole : polygon.holes) addRing(hole, toColor(polygon.id, 1.0F), outlines);
  }
  // rviz takes an empty list for an error.
  if (!faces.points.empty()) array.markers.push_back(std::move(faces));
  if (!outlines.points.empty()) array.markers.push_back(std::move(outlines));
  for (const PlanarRegion& region : segmentation.regions) array.markers.push_back(makeText(region, header));
  return array;
}

}  // namespace ppc
