// SPDX-License-Identifier: BSD-3-Clause
#include "plane_files.h"

#include "files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

namespace ppc {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMost = 1e9;          // of lengths [m] and areas [m^2]: what is beyond is no measurement
constexpr double kUnitSlack = 1e-3;    // of normals that were rounded
constexpr std::size_t kLongWord = 40;  // of what a message cites

[[noreturn]] void refuse(const std::string& name, const Json& value, const std::string& allowed) {
  // What is nested is told by its kind: it may be without end.
  const std::string given =
      value.is_structured() ? std::string("an ") + value.type_name() : value.dump().substr(0, kLongWord);
  throw std::runtime_error(name + " is " + given + ", not " + allowed);
}

double number(const Json& value, const std::string& name, double least) {
  if (value.is_number() && least <= value.get<double>() && value.get<double>() <= kMost) return value.get<double>();
  std::ostringstream allowed;
  allowed << "a number in [" << least << ", " << kMost << "]";
  refuse(name, value, allowed.str());
}

std::int32_t whole(const Json& plane, const std::string& name, std::int32_t least) {
  constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
  const Json& value = plane.at(name);
  // As a double, for what is beyond 64 bits is one; 32 bits fit into it.
  if (value.is_number_integer() && least <= value.get<double>() && value.get<double>() <= kLargest)
    return value.get<std::int32_t>();
  refuse(name, value, "a whole number in [" + std::to_string(least) + ", " + std::to_string(kLargest) + "]");
}

Eigen::Vector3d triple(const Json& value, const std::string& name) {
  if (!value.is_array() || value.size() != 3) refuse(name, value, "three numbers");
  return {number(value[0], name, -kMost), number(value[1], name, -kMost), number(value[2], name, -kMost)};
}

std::vector<Eigen::Vector3d> ring(const Json& value, const std::string& name) {
  if (!value.is_array()) refuse(name, value, "a list of points");
  std::vector<Eigen::Vector3d> points;
  for (const Json& each : value) points.push_back(triple(each, "a vertex of " + name));
  return points;
}

Plane planeOf(const Json& json) {
  const Json& normal = json.at("normal");
  Plane plane{triple(normal, "normal"), number(json.at("d"), "d", -kMost)};
  if (!(std::abs(plane.normal.norm() - 1.0) < kUnitSlack)) {
    throw std::runtime_error("normal is of length " + std::to_string(plane.normal.norm()) + ", not 1");
  }
  return plane;
}

PlanarPolygon polygonOf(const Json& json) {
  PlanarPolygon polygon;
  polygon.id = whole(json, "id", 1);
  polygon.outer = ring(json.at("outer"), "outer");
  polygon.area = number(json.at("area"), "area", 0.0);
  const Json& holes = json.at("holes");
  if (!holes.is_array()) refuse("holes", holes, "a list of rings");
  for (const Json& hole : holes) polygon.holes.push_back(ring(hole, "holes"));
  return polygon;
}

// Calls `take` for each of the file's planes; what that throws is told with the plane's place in the file.
void readEach(const std::string& path, const std::string& kind, const std::function<void(const Json&)>& take) {
  requireReadableFile(path);
  std::string where;
  try {
    std::ifstream in(path);
    const Json json = Json::parse(in);
    const Json& planes = json.at("planes");
    if (!planes.is_array()) refuse("planes", planes, "a list");
    for (std::size_t i = 0; i < planes.size(); ++i) {
      where = "plane " + std::to_string(i + 1) + ": ";
      take(planes[i]);
    }
  } catch (const std::runtime_error& error) {  // not nlohmann's, which are exceptions of their own
    throw std::runtime_error(path + ": is not a " + kind + " (" + where + error.what() + ")");
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(path + ": is not a " + kind + " (" + where + error.what() + ")");
  }
}

bool byId(const PlanarRegion& a, const PlanarRegion& b) { return a.id < b.id; }

}  // namespace

Segmentation readPolygons(const std::string& path) {
  Segmentation result;
  readEach(path, "polygons file", [&](const Json& json) {
    result.polygons.push_back(polygonOf(json));
    PlanarRegion region;
    region.id = result.polygons.back().id;
    region.plane = planeOf(json);
    region.rms = number(json.at("rms"), "rms", 0.0);
    region.points = whole(json, "points", 0);
    // A region has an entry for each of its polygons.
    const auto at = std::lower_bound(result.regions.begin(), result.regions.end(), region, byId);
    if (at == result.regions.end() || at->id != region.id) {
      result.regions.insert(at, region);
    } else if (at->plane.normal != region.plane.normal || at->plane.d != region.plane.d) {
      throw std::runtime_error("id " + std::to_string(region.id) + " has another plane before");
    }
  });
  return result;
}

std::vector<PlanarRegion> readPlanes(const std::string& path) {
  std::vector<PlanarRegion> planes;
  readEach(path, "file of planes", [&](const Json& json) {
    PlanarRegion region;
    region.id = whole(json, "id", 1);
    region.plane = planeOf(json);
    const auto at = std::lower_bound(planes.begin(), planes.end(), region, byId);
    if (at != planes.end() && at->id == region.id) {
      throw std::runtime_error("id " + std::to_string(region.id) + " was there before");
    }
    planes.insert(at, region);
  });
  return planes;
}

}  // namespace ppc
