// SPDX-License-Identifier: BSD-3-Clause
#include "result_files.h"

#include "files.h"
#include "patch_plane_clustering/ros/region_color.h"
#include "patch_plane_clustering/ros/triangulation.h"

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace ppc {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPixels = 100000000;  // as of clouds and messages

Json ringJson(const std::vector<Eigen::Vector3d>& ring) {
  Json all = Json::array();
  for (const auto& p : ring) all.push_back({p.x(), p.y(), p.z()});
  return all;
}

// Row by row.
Json covarianceJson(const Eigen::Matrix4d& covariance) {
  Json json = Json::array();
  for (Eigen::Index row = 0; row < covariance.rows(); ++row) {
    for (Eigen::Index column = 0; column < covariance.cols(); ++column) json.push_back(covariance(row, column));
  }
  return json;
}

}  // namespace

cv::Mat labelPicture(const LabelImage& labels) {
  cv::Mat picture(labels.rows, labels.cols, CV_16UC1);
  for (int r = 0; r < labels.rows; ++r) {
    for (int c = 0; c < labels.cols; ++c) {
      const auto label = labels.labels[static_cast<std::size_t>(r) * labels.cols + c];
      if (label > 65535) throw std::runtime_error("more than 65535 regions do not fit a 16-bit label image");
      picture.at<std::uint16_t>(r, c) = static_cast<std::uint16_t>(label);
    }
  }
  return picture;
}

LabelImage readLabels(const std::string& path) {
  requireReadableFile(path);
  cv::Mat picture;
  try {
    const Quiet quiet;
    picture = cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw std::runtime_error(path + ": cannot be read as a picture (" + error.err + ")");
  }
  if (picture.empty()) throw std::runtime_error(path + ": cannot be read as a picture");
  if (picture.channels() != 1 || (picture.depth() != CV_8U && picture.depth() != CV_16U)) {
    throw std::runtime_error(path + ": is not a label image (one channel of 8 or 16 bits)");
  }
  if (picture.total() > kMostPixels) throw std::runtime_error(path + ": is larger than any range image");
  picture.convertTo(picture, CV_32S);
  LabelImage labels{picture.rows, picture.cols, {}};
  labels.labels.assign(picture.begin<std::int32_t>(), picture.end<std::int32_t>());
  return labels;
}

Json polygonsJson(const BeamGrid& grid, const Segmentation& result, const ImageSource& source) {
  Json planes = Json::array();
  for (const PlanarPolygon& polygon : result.polygons) {
    for (const PlanarRegion& region : result.regions) {
      if (region.id != polygon.id) continue;
      const auto& n = region.plane.normal;
      Json holes = Json::array();
      for (const auto& hole : polygon.holes) holes.push_back(ringJson(hole));
      planes.push_back({{"id", region.id},
                        {"normal", {n.x(), n.y(), n.z()}},
                        {"d", region.plane.d},
                        {"covariance", covarianceJson(region.covariance)},
                        {"rms", region.rms},
                        {"points", region.points},
                        {"area", polygon.area},
                        {"outer", ringJson(polygon.outer)},
                        {"holes", holes}});
    }
  }
  return {
      {"frame_id", source.frame_id}, {"stamp", source.stamp}, {"rows", grid.rows}, {"cols", grid.cols}, {"planes", planes}};
}

Json statisticsJson(const BeamGrid& grid, const Segmentation& result) {
  int planar = 0;
  double squares = 0.0;
  for (const PlanarRegion& region : result.regions) {
    planar += region.points;
    squares += region.points * region.rms * region.rms;
  }
  std::size_t vertices = 0;
  for (const PlanarPolygon& polygon : result.polygons) {
    vertices += polygon.outer.size();
    for (const auto& hole : polygon.holes) vertices += hole.size();
  }
  Json stages = Json::object();
  double total = 0.0;
  for (const auto& [name, ms] : result.stages) {
    stages[name] = std::round(ms * 1e4) / 1e4;
    total += ms;
  }
  Json json;
  json["rows"] = grid.rows;
  json["cols"] = grid.cols;
  json["valid_points"] = result.valid_points;
  json["planar_points"] = planar;
  json["coverage"] = result.valid_points > 0 ? static_cast<double>(planar) / result.valid_points : 0.0;
  json["regions"] = result.regions.size();
  json["polygons"] = result.polygons.size();
  json["vertices"] = vertices;
  json["regions_without_polygon"] = result.regions_without_polygon;
  // Points and vertices both cost three coordinates; null where nothing was found.
  json["compression"] =
      vertices > 0 ? Json(static_cast<double>(result.valid_points) / static_cast<double>(vertices)) : Json();
  json["rms"] = planar > 0 ? Json(std::sqrt(squares / planar)) : Json();
  json["stages_ms"] = stages;
  json["total_ms"] = std::round(total * 1e4) / 1e4;
  return json;
}

std::string meshPly(const Segmentation& result) {
  std::ostringstream vertices;
  vertices.imbue(std::locale::classic());
  vertices.precision(9);
  std::size_t n = 0;
  for (const PlanarPolygon& polygon : result.polygons) {
    const RegionColor colour = regionColor(polygon.id);
    for (const PlanarRegion& region : result.regions) {
      if (region.id != polygon.id) continue;
      for (const Eigen::Vector3d& p : triangulate(polygon, region.plane.normal)) {
        vertices << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << int{colour.r} << ' ' << int{colour.g} << ' '
                 << int{colour.b} << '\n';
        ++n;
      }
    }
  }
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\ncomment planar polygons [m]\nelement vertex " << n
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
         "property uchar blue\nelement face "
      << n / 3 << "\nproperty list uchar int vertex_indices\nend_header\n"
      << vertices.str();
  for (std::size_t i = 0; i + 2 < n; i += 3) out << "3 " << i << ' ' << i + 1 << ' ' << i + 2 << '\n';
  return out.str();
}

}  // namespace ppc
